"""Run metadata: what differs from run to run, noted beside each result, in no recipe."""

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
    """Run metadata of plain values, such as those of a file or a remote.

    Raises:
        ValueError: they are no table of numbers and texts, or a number or time is none.
    """
    if isinstance(values, dict) and all(isinstance(v, int | float | str) for v in values.values()):
        for time in filter(None, map(values.get, _TIMES)):
            datetime.fromisoformat(str(time))
        if all(isinstance(values.get(name, 0.0), int | float) for name in _NUMBERS):
            return values
    raise ValueError("expected a table of numbers and texts")


def revision() -> dict[str, str]:
    """``commit`` of the source and whether tracked files differ from it (``dirty``).

    Empty where the source is in no git repository, an archive unpacked within another one included,
    or git is not installed.
    """
    commit = _ask_git("rev-parse", "HEAD")
    if not commit or not _ask_git("ls-files"):
        return {}
    dirty = bool(_ask_git("status", "--porcelain", "--untracked-files=no"))
    return {"commit": commit, "dirty": str(dirty).lower()}


def _ask_git(*arguments: str) -> str:
    """Answer of git about the repository of the source, also of another user's clone."""
    environment = {name: v for name, v in os.environ.items() if not name.startswith("GIT_")}
    command = ["git", "-c", "safe.directory=*", *arguments]
    try:
        answer = subprocess.run(command, cwd=_SOURCE, env=environment, capture_output=True)
    except OSError:  # no git on this machine
        return ""
    return answer.stdout.decode(errors="replace").strip() if answer.returncode == 0 else ""


def now() -> str:
    """Time of this moment, to the millisecond."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def computed_seconds(metadata: Mapping[str, Any], since: float) -> float | None:
    """Wall time of the computation of a result [s]; none where it ended before, or was reused."""
    with suppress(ValueError, KeyError, TypeError):
        if metadata["computed"] and datetime.fromisoformat(metadata["ended"]).timestamp() > since:
            return float(metadata["wall_s"])
    return None


def note_start(artefacts: Path, overrides: Sequence[str] = ()) -> None:
    """Begin a pipeline run with overrides of the configuration: jobs from here on belong to it."""
    words = []
    for override in overrides:  # none begins with a quote: --config takes quotes off both ends
        name, equals, value = override.partition("=")
        quoted = equals and set(value) & set(" \t\n'\"\\")
        words.append(f"{name}={shlex.quote(value)}" if quoted else override)
    files.write_atomic(artefacts / _START, f"{now()}\n{' '.join(words)}\n")


def config_option(overrides: str) -> str:
    """Overrides as a shell needs them behind ``snakemake``; nothing for none."""
    asked = overrides + " " * overrides.endswith("'")  # Snakemake takes quotes off both ends
    return f" --config hydra={shlex.quote(asked)}" if overrides else ""


def pipeline_metadata(artefacts: Path) -> dict[str, str]:
    """``commit`` and ``dirty``, and of the run that the job belongs to its start and overrides."""
    return revision() | _last_run(artefacts)


def last_robot(artefacts: Path) -> list[str]:
    """Overrides of the last pipeline run that are about the robot; none before the first."""
    overrides = shlex.split(_last_run(artefacts).get("overrides", ""))
    return [text for text in overrides if text.startswith(("robot=", "robot."))]


def _last_run(artefacts: Path) -> dict[str, str]:
    """Start of the last pipeline run, and its overrides; empty before the first."""
    if not (path := artefacts / _START).is_file():
        return {}
    started, _, overrides = path.read_text("utf-8", "replace").partition("\n")
    return ({"pipeline_started": started} if started else {}) | {"overrides": overrides.strip()}
