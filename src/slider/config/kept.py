"""Compositions, kept beside the bytecode: Hydra takes most of a second, half of it to be imported.

A composition is used for the very files and overrides that it was made of, and by the code that
made it. One that reads anything else, such as the environment, is made again each time.
"""

import hashlib
import json
import os
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

from slider.core.files import canonical, digest_text

_MOST = 64  # files, of 30 kB each
_MAKERS = ("hydra-core", "omegaconf", "PyYAML")
_SOURCES = ("untyped.py", "validation/checks.py")
_FROM_OUTSIDE = re.compile(r"\$\{\s*(?!steps\b|joined\b)[\w.]+\s*:|searchpath")
_FOLDER = Path(__file__).parent
_KEPT = _FOLDER / "__pycache__"


def composed(overrides: Sequence[str], conf: Path) -> dict[str, Any]:
    """Resolve ``conf/config.yaml`` as :func:`slider.config.untyped.compose_untyped` does.

    Raises:
        UserError: as there.
    """
    contents = _contents(conf)
    path = _KEPT / f"composed-{_key([*overrides], contents)}.{sys.implementation.cache_tag}.json"
    values = _read(path)
    if values is None:
        from slider.config.untyped import compose_untyped

        values = compose_untyped(overrides, conf)
        if not any(map(_FROM_OUTSIDE.search, [*overrides, *contents])):
            _keep(values, path)
    return values


def _contents(conf: Path) -> list[str]:
    """Name and content of each file that Hydra may read."""
    paths = sorted(path for path in conf.rglob("[!.]*.yaml") if path.is_file())
    return [f"{p.relative_to(conf)}\n{p.read_bytes().decode('latin-1')}" for p in paths]


def _key(*asked: list[str]) -> str:
    sources = [(_FOLDER / name).read_bytes() for name in _SOURCES]
    made_by = [*map(version, _MAKERS), *sources]
    return hashlib.sha256(repr([made_by, *asked]).encode()).hexdigest()


def _read(path: Path) -> dict[str, Any] | None:
    """What a file says; nothing where there is none, or a damaged one."""
    with suppress(OSError, ValueError):
        digest, _, text = path.read_text(encoding="utf-8").partition("\n")
        if digest == digest_text(text):
            return json.loads(text)
    return None


def _keep(values: dict[str, Any], path: Path) -> None:
    """Write a file at once: what is torn has another digest. The oldest go."""
    with suppress(OSError, ValueError, TypeError):
        text = canonical(values)
        if repr(json.loads(text)) != repr(values):
            return
        path.parent.mkdir(exist_ok=True)
        part = path.with_suffix(f".{os.getpid()}")
        part.write_text(f"{digest_text(text)}\n{text}", encoding="utf-8")
        part.replace(path)
        kept = sorted(path.parent.glob("composed-*"), key=lambda one: one.stat().st_mtime)
        for old in kept[:-_MOST]:
            old.unlink(missing_ok=True)
