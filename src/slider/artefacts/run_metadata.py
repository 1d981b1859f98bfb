"""Run metadata: what differs from run to run; stored beside each result, not part of a recipe."""

import math
import os
import shlex
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from slider.core import files

_SOURCE = Path(__file__).parent
_START = "current/started"
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


def note_start(artefacts: Path, overrides: Sequence[str] = ()) -> None:
    """Record the start and overrides of a pipeline run; jobs from now on belong to it."""
    words = []
    for override in overrides:  # must not begin with a quote: --config strips quotes at both ends
        name, equals, value = override.partition("=")
        quoted = equals and set(value) & set(" \t\n'\"\\")
        words.append(f"{name}={shlex.quote(value)}" if quoted else override)
    files.write_atomic(artefacts / _START, f"{now()}\n{' '.join(words)}\n")


def config_option(overrides: str) -> str:
    """Overrides as a shell-quoted option of ``snakemake``; empty without overrides."""
    asked = overrides + " " * overrides.endswith("'")  # Snakemake strips quotes at both ends
    return f" --config hydra={shlex.quote(asked)}" if overrides else ""


def pipeline_metadata(artefacts: Path) -> dict[str, str]:
    """``commit`` and ``dirty``, and start and overrides of the pipeline run of a job."""
    return revision() | _last_run(artefacts)


def last_robot(artefacts: Path) -> list[str]:
    """Overrides of the last pipeline run that concern the robot; empty before the first run."""
    overrides = shlex.split(_last_run(artefacts).get("overrides", ""))
    return [text for text in overrides if text.startswith(("robot=", "robot."))]


def _last_run(artefacts: Path) -> dict[str, str]:
    """Start and overrides of the last pipeline run; empty before the first run."""
    if not (path := artefacts / _START).is_file():
        return {}
    started, _, overrides = path.read_text("utf-8", "replace").partition("\n")
    return ({"pipeline_started": started} if started else {}) | {"overrides": overrides.strip()}
