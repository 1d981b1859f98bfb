"""The one process that writes to MLflow: it follows the journals of a session.

It runs beside the pipeline, so that runs can be watched while they train, and ends with it. What
a killed writer leaves behind, the next one brings to its end.
"""

import json
import logging
import os
import shutil
import sqlite3
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider.core import files
from slider.tracking import journal
from slider.tracking.journal import FAILED, MAIN, METRICS, SESSION_FILE, SessionInfo, is_alive

DATABASE = "mlflow.db"  # below artefacts/
_PERIOD = 1.0  # between two looks at the journals [s]
_MAX_PARAM = 5000  # characters of a parameter's value
_PARENT_TAG = "mlflow.parentRunId"
_NOTE_TAG = "mlflow.note.content"
_KIND = ("mlflow.experimentKind", "custom_model_development")  # else for language models

_log = logging.getLogger(__name__)


def follow(artefacts: Path, name: str) -> None:
    """Write a session to MLflow until it ends; first what earlier sessions left behind."""
    client = _connect(artefacts)
    for path in sorted((artefacts / "tracking").glob(f"*/{SESSION_FILE}")):
        folder = path.parent
        try:
            if folder.name != name and not is_alive(SessionInfo.read(folder).owner):
                _Session(client, artefacts, folder).close()
        except Exception as error:  # must not keep the present session from being written
            _log.warning("lost the tracking of %s: %s", folder.name, error)
            shutil.rmtree(folder, ignore_errors=True)
    session = _Session(client, artefacts, artefacts / "tracking" / name)
    while not session.update():
        time.sleep(_PERIOD)
    session.close()


def _connect(artefacts: Path) -> Any:
    os.environ["MLFLOW_DISABLE_TELEMETRY"] = "true"
    from mlflow import MlflowClient

    database = (artefacts / DATABASE).resolve()
    # MLflow tries a broken database again for almost two minutes: ask SQLite first.
    with closing(sqlite3.connect(database)) as connection:
        connection.execute("PRAGMA schema_version")
    # MLflow pastes the path of this folder into SQL; in an address a quote of it is %27.
    os.environ["_MLFLOW_SERVER_ARTIFACT_ROOT"] = _files(artefacts)
    return MlflowClient(f"sqlite:///{database}")


@dataclass
class _Position:
    """How far a journal has been written, the run that it goes to, and what that is noted with."""

    run: str = ""
    offset: int = 0
    ended: bool = False
    note: str = ""


class _Session:
    """Journals of one pipeline run on their way to MLflow."""

    def __init__(self, client: Any, artefacts: Path, folder: Path) -> None:
        self._client = client
        self._folder = folder
        self._info = SessionInfo.read(folder)
        names = {self._info.experiment, *self._info.apart.values()}
        self._experiments = {name: _experiment(client, artefacts, name) for name in sorted(names)}
        self._state_path = folder / "written.json"
        state = files.read_json(self._state_path) if self._state_path.is_file() else {}
        self._positions = {name: _Position(**position) for name, position in state.items()}

    def update(self) -> bool:
        """Write what is new; tell whether the session is over."""
        alive = is_alive(self._info.owner)  # before reading: nothing is missed
        journals = sorted(self._folder.glob("*.jsonl"))
        # The pipeline's own journal first: its run is the parent of all others.
        for path in sorted(journals, key=lambda path: path.stem != MAIN):
            self._update_journal(path)
        return self._position(MAIN).ended or not alive

    def close(self) -> None:
        """Write the rest, mark runs that never ended as failed, and forget the session."""
        self.update()
        for position in self._positions.values():
            if position.run and not position.ended:
                self._client.set_terminated(position.run, FAILED)
        shutil.rmtree(self._folder)

    def _position(self, name: str) -> _Position:
        return self._positions.setdefault(name, _Position())

    def _update_journal(self, path: Path) -> None:
        position = self._position(path.stem)
        with path.open("rb") as file:
            file.seek(position.offset)
            content = file.read()
        lines = content[: content.rfind(b"\n") + 1]  # whole ones
        events = [json.loads(line) for line in lines.splitlines()]
        if not events:
            return
        metrics = [event for event in events if event["event"] == METRICS]
        for event in events:
            if event["event"] == journal.END:  # an ended run takes no metrics
                self._try(self._log_metrics, position.run, metrics)
                metrics = []
            self._try(self._handle, event, position, path.stem)
        self._try(self._log_metrics, position.run, metrics)
        position.offset += len(lines)
        state = {name: vars(position) for name, position in self._positions.items()}
        files.write_json(self._state_path, state)

    def _try(self, write: Callable[..., None], *arguments: Any) -> None:
        """Write, or log what MLflow refuses, such as a parameter that changes, and go on."""
        from mlflow.exceptions import MlflowException

        try:
            write(*arguments)
        except (MlflowException, OSError, TypeError, ValueError) as error:
            _log.warning("%s: %s", self._folder.name, error)

    def _handle(self, event: dict[str, Any], position: _Position, name: str) -> None:
        from mlflow.entities import Param, RunTag

        client, run = self._client, position.run
        match event["event"]:
            case journal.BEGIN:
                self._begin(event, position, name)
            case journal.PARAMS:
                params = [Param(k, value[:_MAX_PARAM]) for k, value in event["values"].items()]
                client.log_batch(run, params=params)
            case journal.TABLE:
                client.log_table(run, event["columns"], f"{event['name']}.json")
            case journal.FILE:
                client.log_artifact(run, event["path"])
            case journal.END:
                note = "\n\n".join(filter(None, [position.note, event.get("note")]))
                tags = event["tags"] | ({_NOTE_TAG: note} if note else {})
                client.log_batch(run, tags=[RunTag(k, v) for k, v in tags.items()])
                client.set_terminated(run, event["status"], end_time=event["time"])
                position.ended = True

    def _begin(self, event: dict[str, Any], position: _Position, name: str) -> None:
        """Create the run, and note links to the experiments of the runs that it used."""
        apart = self._info.apart
        used = [apart[stage] for stage in event.get("needs", ()) if stage in apart]
        links = ", ".join(f"[{one}](#{page(self._experiments[one])})" for one in used)
        position.note = f"Made from the runs of {links}." if links else ""
        own = apart.get(event["tags"].get("stage"))
        parent = {} if name == MAIN else {_PARENT_TAG: self._position(MAIN).run}
        if own is not None:  # pages show parents beside their children: not in two experiments
            parent = {"pipeline": self._position(MAIN).run}
        run = self._client.create_run(
            self._experiments[own or self._info.experiment],
            start_time=event["time"],
            tags={**self._info.tags, **event["tags"], **parent},
            run_name=event["name"],
        )
        position.run = run.info.run_id

    def _log_metrics(self, run: str, events: Sequence[dict[str, Any]]) -> None:
        from mlflow.entities import Metric

        metrics = [
            Metric(key, value, event["time"], event["step"])
            for event in events
            for key, value in event["values"].items()
        ]
        self._client.log_batch(run, metrics)


def page(experiment: str) -> str:
    """Part of MLflow's address that lists runs; without a type it shows another page."""
    return f"/experiments/{experiment}/runs?workflowType=machine_learning"


def _experiment(client: Any, artefacts: Path, name: str) -> str:
    known = client.get_experiment_by_name(name)
    experiment = known.experiment_id if known else client.create_experiment(name, _files(artefacts))
    client.set_experiment_tag(experiment, *_KIND)
    return experiment


def _files(artefacts: Path) -> str:
    """Address of the folder with the runs' files."""
    return (artefacts / "mlruns").resolve().as_uri()
