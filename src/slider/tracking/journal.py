"""Tracking as seen by a job: a journal that one writer process brings to MLflow.

Jobs append lines to a file of their own. None of them imports MLflow (1.8 s each) or opens its
database, where several writers at once lose runs; a broken tracker cannot break a stage; and a
job on another machine needs nothing but the shared folder.

``tracking/<session>/`` holds the journals of one pipeline run, with one writer process that feeds
MLflow; ``tracking/current`` names it.
"""

import json
import logging
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from slider.core import files
from slider.core.files import flatten

SESSION_FILE = "session.json"
MAIN = "main"  # journal of the pipeline run itself
BEGIN, PARAMS, METRICS, TABLE, FILE, END = "begin", "params", "metrics", "table", "file", "end"
FINISHED, FAILED = "FINISHED", "FAILED"

_log = logging.getLogger(__name__)
_PATIENCE = 60.0  # for the writer to finish [s]


class JournalTracker:
    """Tracker that appends to a journal. Never raises; the first failure is logged as one line."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._broken = False

    def begin(self, name: str, tags: Mapping[str, str], needs: Sequence[str] = ()) -> None:
        """Open the run under a name; ``needs`` are the stages whose results it uses."""
        self._append(BEGIN, lambda: {"name": name, "tags": dict(tags), "needs": list(needs)})

    def end(self, status: str, tags: Mapping[str, str], note: str = "") -> None:
        """Close the run as ``FINISHED`` or ``FAILED``, with a note in Markdown."""
        self._append(END, lambda: {"status": status, "tags": dict(tags), "note": note})

    def log_params(self, params: Mapping[str, Any]) -> None:
        """Record nested parameters of the run."""
        self._append(PARAMS, lambda: {"values": {k: str(v) for k, v in flatten(params).items()}})

    def log_metrics(self, metrics: Mapping[str, float], step: int) -> None:
        """Record scalar metrics at a step."""
        self._append(
            METRICS,
            lambda: {"step": int(step), "values": {k: float(v) for k, v in metrics.items()}},
        )

    def log_table(self, table: Mapping[str, Sequence[Any]], name: str) -> None:
        """Record columns of equal length as a table."""
        self._append(TABLE, lambda: {"name": name, "columns": files.plain(table)})

    def log_file(self, path: Path) -> None:
        """Record a file as an artefact of the run; it may be moved afterwards."""
        self._append(FILE, lambda: {"path": self._copy(path)})

    def _copy(self, path: Path) -> str:
        folder = self._path.with_suffix(".files")
        folder.mkdir(exist_ok=True)
        return str(shutil.copyfile(path, folder / path.name))

    def _append(self, event: str, values: Callable[[], Mapping[str, Any]]) -> None:
        if self._broken:
            return
        try:
            line = json.dumps({"event": event, "time": time.time_ns() // 1_000_000, **values()})
            with self._path.open("a", encoding="utf-8") as file:
                file.write(line + "\n")
        except Exception as error:
            self._broken = True
            _log.warning("tracking stops here, the stage goes on: %s", error)


def current_session(artefacts: Path) -> Path | None:
    """Folder of the pipeline run that is being tracked, if there is one."""
    try:
        name = (artefacts / "tracking" / "current").read_text("utf-8", "replace").strip()
    except OSError:
        return None
    session = artefacts / "tracking" / name
    return session if (session / SESSION_FILE).is_file() else None


@dataclass(frozen=True)
class SessionInfo:
    """Settings of a session, for its writer.

    It ends with the process ``owner``. All runs have the ``tags``, such as the commit. ``apart``
    are stage → experiment of its own, for many runs that would bury the others.
    """

    experiment: str
    owner: int
    tags: Mapping[str, str]
    apart: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def read(cls, folder: Path) -> "SessionInfo":
        """Read the settings of the session in a folder."""
        return cls(**files.read_json(folder / SESSION_FILE))


def start(
    artefacts: Path, info: SessionInfo, name: str, tags: Mapping[str, str], params: Mapping
) -> "Session":
    """Open a session, with name, tags and parameters of the pipeline run; start its writer."""
    folder = artefacts / "tracking" / time.strftime(f"%Y%m%dT%H%M%S-{os.getpid()}", time.gmtime())
    folder.mkdir(parents=True)
    files.write_json(folder / SESSION_FILE, asdict(info))
    journal = JournalTracker(folder / f"{MAIN}.jsonl")
    journal.begin(name, tags)
    journal.log_params(params)
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
    with log.open("ab") as output:
        return subprocess.Popen(
            [*command, "--artefacts", str(artefacts)],
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            start_new_session=True,  # Ctrl-C ends the pipeline; the writer still closes its runs
        )
