"""Run metadata: what differs from run to run; stored beside each result, not part of a recipe."""

import json
import math
import os
import shlex
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from slider.core import files

_SOURCE = Path(__file__).parent
STARTED = ".started"
"""Suffix of the file that a run writes beside its plan."""
_NUMBERS = ("wall_s", "cpu_s", "solve_cpu", "size")
_TIMES = ("started", "ended", "pipeline_started")


def validate_metadata(values: Any) -> dict[str, Any]:
    """Run metadata, if plain values from a file or a remote are valid.

    Raises:
        ValueError: they are not a table of numbers and texts, or a number or time is invalid.
    """
    if isinstance(values, dict) and all(isinstance(v, int | float | str) for v in values.values()):
        for time in filter(None, map(values.get, _TIMES)):
            datetime.fromisoformat(str(time))
        numbers = [values.get(name, 0.0) for name in _NUMBERS]
        if all(isinstance(n, int | float) and 0.0 <= n < math.inf for n in numbers):
            return values
    raise ValueError("expected a table of numbers and texts")


def revision() -> dict[str, str]:
    """``commit`` of the source and whether tracked files differ from it (``dirty``).

    Empty if git is not installed or the source is not in a git repository of its own (such as an
    archive unpacked inside another repository).
    """
    commit = _ask_git("rev-parse", "HEAD")
    if not commit or not _ask_git("ls-files"):
        return {}
    dirty = bool(_ask_git("status", "--porcelain", "--untracked-files=no"))
    return {"commit": commit, "dirty": str(dirty).lower()}


def _ask_git(*arguments: str) -> str:
    """Output of git for the repository of the source, even if another user owns it."""
    environment = {name: v for name, v in os.environ.items() if not name.startswith("GIT_")}
    command = ["git", "-c", "safe.directory=*", *arguments]
    try:
        answer = subprocess.run(command, cwd=_SOURCE, env=environment, capture_output=True)
    except OSError:  # no git on this machine
        return ""
    return answer.stdout.decode(errors="replace").strip() if answer.returncode == 0 else ""


def now() -> str:
    """Current time (UTC, ISO 8601), to the millisecond."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def computed_seconds(metadata: Mapping[str, Any], since: float) -> float | None:
    """Wall time of computing a result [s]; None if it ended before ``since`` or was reused."""
    with suppress(ValueError, KeyError, TypeError):
        if metadata["computed"] and datetime.fromisoformat(metadata["ended"]).timestamp() > since:
            return float(metadata["wall_s"])
    return None


def note_start(plan: Path, overrides: Sequence[str] = (), forced: Iterable[str] = ()) -> None:
    """Record beside its plan the start and overrides of a run, and recipes to compute again."""
    words = []
    for override in overrides:  # must not begin with a quote: --config strips quotes at both ends
        name, equals, value = override.partition("=")
        quoted = equals and set(value) & set(" \t\n'\"\\")
        words.append(f"{name}={shlex.quote(value)}" if quoted else override)
    start = {"pipeline_started": now(), "overrides": " ".join(words), "forced": [*forced]}
    files.write_json(plan.with_suffix(STARTED), start)


def config_option(overrides: str) -> str:
    """Overrides as a shell-quoted option of ``snakemake``; empty without overrides."""
    asked = overrides + " " * overrides.endswith("'")  # Snakemake strips quotes at both ends
    return f" --config hydra={shlex.quote(asked)}" if overrides else ""


def pipeline_metadata(plan: Path) -> dict[str, str]:
    """``commit`` and ``dirty``, and start and overrides of the latest run of a plan, if any."""
    return revision() | {n: text for n, text in _start(plan).items() if n != "forced"}


def was_started(plan: Path) -> bool:
    """Whether a plan was run."""
    return plan.with_suffix(STARTED).exists()


def forced_recipes(plan: Path) -> list[str]:
    """Recipes that the latest run of a plan is to compute again."""
    return _start(plan).get("forced", [])


def last_robot(artefacts: Path) -> list[str]:
    """Overrides of the last pipeline run that concern the robot; empty before the first run."""
    runs = sorted((artefacts / "plans").glob(f"*{STARTED}"), key=lambda path: path.stat().st_mtime)
    overrides = [
        text for path in runs[-1:] for text in shlex.split(_start(path).get("overrides", ""))
    ]
    return [text for text in overrides if text.startswith(("robot=", "robot."))]


def _start(plan: Path) -> dict[str, Any]:
    """What :func:`note_start` recorded beside a plan; empty if it was never run."""
    with suppress(OSError, ValueError):
        values = json.loads(plan.with_suffix(STARTED).read_text("utf-8"))
        return values if isinstance(values, dict) else {}
    return {}
