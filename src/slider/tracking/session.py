"""Sessions of tracking: one per pipeline run, each with one writer process that feeds MLflow.

See :mod:`slider.tracking.journal` for why jobs do not talk to MLflow themselves.
"""

import logging
import os
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from slider.core import files
from slider.tracking.journal import MAIN, SESSION_FILE, JournalTracker

_log = logging.getLogger(__name__)

_PATIENCE = 60.0  # for the writer to finish [s]


@dataclass(frozen=True)
class SessionInfo:
    """What the writer must know.

    Attributes:
        experiment: name of the MLflow experiment.
        owner: process whose end ends the session.
        tags: of all runs, such as the commit.
        apart: stage → experiment of its own, for many runs that would bury the others.
    """

    experiment: str
    owner: int
    tags: Mapping[str, str]
    apart: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def read(cls, folder: Path) -> "SessionInfo":
        """That of the session in a folder."""
        return cls(**files.read_json(folder / SESSION_FILE))


def start(artefacts: Path, info: SessionInfo, run: Mapping[str, Any]) -> "Session":
    """Open a session and start its writer.

    ``run`` describes the pipeline run: its ``name``, ``tags`` and ``params``.
    """
    folder = artefacts / "tracking" / time.strftime(f"%Y%m%dT%H%M%S-{os.getpid()}", time.gmtime())
    folder.mkdir(parents=True)
    files.write_json(folder / SESSION_FILE, asdict(info))
    journal = JournalTracker(folder / f"{MAIN}.jsonl")
    journal.begin(run["name"], run["tags"])
    journal.log_params(run["params"])
    files.write_atomic(artefacts / "tracking" / "current", folder.name + "\n")
    return Session(artefacts, folder, _spawn_writer(artefacts, folder))


@dataclass(frozen=True)
class Session:
    """An open session and its writer."""

    artefacts: Path
    folder: Path
    writer: "subprocess.Popen[bytes]"

    def finish(self, status: str) -> None:
        """Close the session as ``FINISHED`` or ``FAILED`` and wait for its writer.

        What a writer that fails or hangs does not write, the next session's will.
        """
        JournalTracker(self.folder / f"{MAIN}.jsonl").end(status, {})
        stop(self.artefacts)
        try:
            status_code = self.writer.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            status_code = None
        if status_code != 0:
            _log.warning("MLflow misses part of this run: see %s", _log_path(self.artefacts))


def stop(artefacts: Path) -> None:
    """Let no further job write to a session, such as one that a killed pipeline left behind."""
    (artefacts / "tracking" / "current").unlink(missing_ok=True)


def is_alive(process: int) -> bool:
    """Tell whether a process of this machine is running."""
    try:
        os.kill(process, 0)
    except OSError as error:
        return isinstance(error, PermissionError)  # there, but not ours
    return True


def _log_path(artefacts: Path) -> Path:
    return artefacts / "logs" / "tracking.log"


def _spawn_writer(artefacts: Path, folder: Path) -> subprocess.Popen[bytes]:
    log = _log_path(artefacts)
    log.parent.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "slider.cli", "tracking", "follow", folder.name]
    with log.open("a", encoding="utf-8") as output:
        return subprocess.Popen(
            [*command, "--artefacts", str(artefacts)],
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            start_new_session=True,  # Ctrl-C ends the pipeline; the writer still closes its runs
        )
