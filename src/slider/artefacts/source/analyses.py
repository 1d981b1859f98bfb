"""Analyses of modules, kept beside their bytecode: to parse them all takes half a second.

An analysis is used for the very bytes that it was made of, and by the code that made it.
"""

import hashlib
import json
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path

from slider.artefacts.source import syntax
from slider.artefacts.source.syntax import Module, analyse
from slider.core import files

_MAKER = hashlib.sha256(Path(syntax.__file__).read_bytes())


class Analyses:
    """Analyses of a package's modules by name; without the file, they are made again."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._known = _load(path)
        self._changed = False

    def read(self, path: Path, name: str) -> Module:
        """Analysis of a module's file as it is now.

        Raises:
            UserError: it does not parse.
        """
        content = path.read_bytes()
        key = _key(path.name, content)
        known = self._known.get(name)
        if known is None or known[0] != key:
            made = analyse(content, name, path.name == "__init__.py")
            known = self._known[name] = (key, made)
            self._changed = True
        return known[1]

    def keep(self) -> None:
        """Write the file if there is anything new, and a place for it."""
        if not self._changed:
            return
        values = {name: [key, m.digest, m.imports] for name, (key, m) in self._known.items()}
        text = files.canonical(values)
        with suppress(OSError):
            files.write_atomic(self._path, f"{files.digest_text(text)}\n{text}")
        self._changed = False


@cache
def analyses_of(package: Path) -> Analyses:
    """Those of a package's folder."""
    return Analyses(package / "__pycache__" / f"analyses.{sys.implementation.cache_tag}.json")


def _key(name: str, content: bytes) -> str:
    """Digest of a module's content and of the code that analyses it."""
    digest = _MAKER.copy()
    digest.update(f"{name}\n".encode() + content)
    return digest.hexdigest()


def _load(path: Path) -> dict[str, tuple[str, Module]]:
    """What the file says; nothing where there is none, or a damaged one."""
    with suppress(OSError, ValueError):
        digest, _, text = path.read_text(encoding="utf-8").partition("\n")
        if digest == files.digest_text(text):
            values = json.loads(text)
            return {name: (key, Module(d, tuple(i))) for name, (key, d, i) in values.items()}
    return {}
