"""Run metadata: what differs from run to run, noted beside each result, in no recipe."""

import os
import shlex
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, NonNegativeFloat

from slider.core import files
from slider.core.errors import UserError, not_read

_SOURCE = Path(__file__).parent
_START = "current/started"


def _time(text: str) -> str:
    datetime.fromisoformat(text)
    return text


_Time = Annotated[str, AfterValidator(_time)]


class _RunMetadata(BaseModel):
    """What has a meaning here, all of it optional; stages add numbers of their own."""

    model_config = ConfigDict(extra="allow", strict=True, allow_inf_nan=False)
    __pydantic_extra__: dict[str, bool | int | float | str] = Field(init=False)
    started: _Time = ""
    ended: _Time = ""
    pipeline_started: _Time = ""
    wall_s: NonNegativeFloat = 0.0
    cpu_s: NonNegativeFloat = 0.0
    solve_cpu: NonNegativeFloat = 0.0
    size: NonNegativeFloat = 0.0
    threads: int = 0
    computed: bool = False
    kind: str = ""
    machine: str = ""
    commit: str = ""
    dirty: Literal["true", "false"] = "false"
    overrides: str = ""
    reused_from: str = ""
    taken_from: str = ""


def validate_metadata(values: Any) -> dict[str, Any]:
    """Run metadata of plain values, such as those of a file or a remote; nothing is trusted.

    Raises:
        ValueError: a value is of another type, or no number or time.
    """
    return _RunMetadata.model_validate(values).model_dump(exclude_unset=True)


def parse_metadata(path: Path) -> dict[str, Any]:
    """Read a file with run metadata.

    Raises:
        NotReadError: there is none, or it cannot be read.
        UserError: it is damaged.
    """
    try:
        return validate_metadata(files.read_json(path))
    except OSError as error:
        raise not_read(error, path) from None
    except ValueError:
        raise UserError(f"expected run metadata, found something else in {path}") from None


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
