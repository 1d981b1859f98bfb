"""Runs in MLflow, written by a thread of the pipeline's process while the jobs run.

Section, manifest and run metadata of a job are logged at its end. While a job runs, only its
metrics are read, from a file that it appends to. So no job imports MLflow (1.8 s) or opens its
database, where concurrent writers lose runs. A pipeline holds a lock named after its MLflow run;
the next pipeline closes runs whose lock is free, since their pipeline was killed.
"""

import json
import os
import queue
import sqlite3
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from typing import Any

from filelock import Timeout

from slider.artefacts.plan import JobSpec, Plan
from slider.artefacts.run_metadata import computed_seconds
from slider.artefacts.store import Store, exclusive
from slider.core import files
from slider.core.files import flatten, plain

DATABASE = "mlflow.db"  # below artefacts/
LATEST = "current/runs"  # part of the address of the latest pipeline's runs
FINISHED, FAILED = "FINISHED", "FAILED"
_MANY = "gait"  # stage without runs: there would be hundreds
_SHOWN = (".csv", ".svg", ".html", ".pt", ".onnx", ".xml", ".json")  # files of a result
_PERIOD, _PATIENCE = 1.0, 60.0  # polling period of running jobs, timeout at the end [s]
ARTIFACT_ROOT = "_MLFLOW_SERVER_ARTIFACT_ROOT"  # private; see tests/test_private.py
_MAX_PARAM = 5000  # characters of a parameter's value
_PARENT = "mlflow.parentRunId"
_KIND = ("mlflow.experimentKind", "custom_model_development")  # the default is language models


@dataclass
class _Run:
    """Run of a job: start time [ms], id in MLflow, and number of bytes read of a metrics file."""

    job: JobSpec
    began: int
    id: str = ""
    read: int = 0
    inode: int = 0


class Tracking:
    """Writes a pipeline run and its jobs to MLflow. Never raises: ``error`` is the first error.

    All runs have the ``common`` tags, such as the commit.
    """

    def __init__(
        self,
        store: Store,
        plan: Plan,
        experiment: str,
        name: str,
        params: Mapping[str, Any],
        tags: Mapping[str, str],
        common: Mapping[str, str],
    ) -> None:
        self.error: Exception | None = None
        self._store, self._plan = store, plan
        self._experiment, self._common = experiment, common
        self._runs: dict[str, _Run] = {}
        self._actions: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        work = (name, params, tags, _now())
        self._thread = threading.Thread(target=self._work, args=work, daemon=True)
        self._thread.start()

    def began(self, recipe: str) -> None:
        """Note that a job is about to start."""
        job = self._plan.jobs[recipe]
        if job.tracked and job.stage != _MANY:
            self._runs[recipe] = _Run(job, _now())

    def ended(self, recipe: str, succeeded: bool = True) -> None:
        """Note that a job succeeded or failed; a job that reused a result has no run."""
        if run := self._runs.pop(recipe, None):
            status, now = FINISHED if succeeded else FAILED, _now()
            self._actions.put(lambda: self._end(run, status, now))

    def finish(self, succeeded: bool) -> None:
        """Close all runs and wait until everything is written."""
        for recipe in [*self._runs]:
            self.ended(recipe, succeeded=False)
        status, now = FINISHED if succeeded else FAILED, _now()
        self._actions.put(lambda: self._client.set_terminated(self._id, status, end_time=now))
        self._actions.put(None)
        self._thread.join(_PATIENCE)
        if self._thread.is_alive():
            self.error = TimeoutError(f"MLflow took longer than {_PATIENCE:g} s")

    def _work(self, *pipeline: Any) -> None:
        """Process the queue of actions, and poll the metrics of running jobs in between."""
        with ExitStack() as held:
            if not self._try(lambda: self._start(held, *pipeline)):
                return
            while True:
                with suppress(queue.Empty):
                    action = self._actions.get(timeout=_PERIOD)
                    if action is None:
                        return
                    self._try(action)
                for run in [*self._runs.values()]:
                    self._try(lambda run=run: self._log_new_metrics(run))

    def _try(self, action: Callable[[], None]) -> bool:
        try:
            action()
        except Exception as error:
            self.error = self.error or error
            return False
        return True

    def _start(
        self, held: ExitStack, name: str, params: Mapping, tags: Mapping, began: int
    ) -> None:
        """Connect, close runs of killed pipelines, create the run of this one and hold its lock."""
        with exclusive(self._store.locks, "tracking"):
            self._client = _connect(self._store)
            self._place = _experiment(self._client, self._experiment)
            _close_killed(self._client, self._store)
            self._id = self._create(name, began, tags, params)
            held.enter_context(exclusive(self._store.locks, self._id))
            # Without the workflow type, MLflow shows another page.
            latest = f"/experiments/{self._place}/runs?workflowType=machine_learning"
            files.write_atomic(self._store.root / LATEST, latest)

    def _create(self, name: str, began: int, tags: Mapping, params: Mapping[str, Any]) -> str:
        from mlflow.entities import Param

        tags = {**self._common, **tags}
        run = self._client.create_run(self._place, start_time=began, tags=tags, run_name=name)
        flat = flatten(params).items()
        values = [Param(key, str(value)[:_MAX_PARAM]) for key, value in flat]
        self._client.log_batch(run.info.run_id, params=values)
        return run.info.run_id

    def _open(self, run: _Run) -> str:
        """Id of the run of a job, which is created if it does not exist yet."""
        if not run.id:
            job = run.job
            tags = {_PARENT: self._id, "stage": job.stage, "recipe": job.recipe}
            run.id = self._create(job.label, run.began, tags, job.section)
        return run.id

    def _log_new_metrics(self, run: _Run) -> None:
        """Write the metrics that a job has appended since the last call."""
        path = self._store.metrics_path(run.job.stage, run.job.recipe)
        if not path.is_file():
            return
        with path.open("rb") as file:
            if (inode := os.fstat(file.fileno()).st_ino) != run.inode:  # of another attempt
                run.inode, run.read = inode, 0
            file.seek(run.read)
            content = file.read()
        lines = content[: content.rfind(b"\n") + 1]  # complete lines
        run.read += len(lines)
        own = (event for event in map(json.loads, lines.splitlines()) if event["time"] >= run.began)
        if metrics := [one for event in own for one in _metrics(**event)]:
            self._client.log_batch(self._open(run), metrics)

    def _end(self, run: _Run, status: str, now: int) -> None:
        metadata = self._store.metadata(run.job.stage, run.job.recipe)
        reused = computed_seconds(metadata, run.began / 1e3) is None
        if status == FINISHED and reused and not run.id:
            return
        self._open(run)
        self._try(lambda: self._log_new_metrics(run))
        if status == FINISHED:
            self._try(lambda: self._log_result(run, metadata, now))
        self._client.set_terminated(run.id, status, end_time=now)

    def _log_result(self, run: _Run, metadata: Mapping[str, Any], now: int) -> None:
        """Write the result of a job: its numbers and files, and a table of its gaits."""
        from mlflow.entities import RunTag

        job, store, client = run.job, self._store, self._client
        result = store.read_manifest(job.stage, job.recipe).result
        of_run = {f"run/{name}": value for name, value in _numbers(metadata).items()}
        summary = {name.replace(".", "/"): value for name, value in flatten(result.summary).items()}
        noted = _numbers(summary) | of_run
        folder = store.object_folder(result.object)
        path = folder.relative_to(store.root).as_posix()
        names = sorted({name.partition("/")[0] for name in result.files})
        tags = [RunTag("object", result.object), RunTag("object.path", path)]
        client.log_batch(run.id, _metrics(now, 0, noted), tags=tags)
        if gaits := [item for item in job.needs if item.stage == _MANY]:
            client.log_table(run.id, _table(store, gaits), f"{_MANY}s.json")
        for name in names:
            if name.endswith(_SHOWN):
                client.log_artifact(run.id, str(folder / name))


def _connect(store: Store) -> Any:
    os.environ["MLFLOW_DISABLE_TELEMETRY"] = "true"
    # MLflow inserts the path of this folder into SQL; in a URI a quote is escaped as %27.
    os.environ[ARTIFACT_ROOT] = (store.root / "mlruns").resolve().as_uri()
    os.environ.setdefault("MLFLOW_LOGGING_LEVEL", "WARNING")
    from mlflow import MlflowClient

    database = (store.root / DATABASE).resolve()
    # MLflow retries a broken database for almost two minutes: test it with SQLite first.
    with closing(sqlite3.connect(database)) as connection:
        connection.execute("PRAGMA schema_version")
    return MlflowClient(f"sqlite:///{database}")


def _experiment(client: Any, name: str) -> str:
    known = client.get_experiment_by_name(name)
    place = os.environ[ARTIFACT_ROOT]
    experiment = known.experiment_id if known else client.create_experiment(name, place)
    client.set_experiment_tag(experiment, *_KIND)
    return experiment


def _close_killed(client: Any, store: Store) -> None:
    """Mark the runs of pipelines that no longer hold their lock as failed."""
    experiments = [experiment.experiment_id for experiment in client.search_experiments()]
    for run in client.search_runs(experiments, "attributes.status = 'RUNNING'"):
        tags, id = run.data.tags, run.info.run_id
        owner = tags.get(_PARENT) or (id if "plan" in tags else None)
        with suppress(Timeout):
            if owner is not None:
                with exclusive(store.locks, owner, timeout=0):
                    client.set_terminated(id, FAILED)


def _metrics(time: int, step: int, values: Mapping[str, float]) -> list[Any]:
    from mlflow.entities import Metric

    return [Metric(name, value, time, step) for name, value in values.items()]


def _table(store: Store, jobs: list[JobSpec]) -> dict[str, list[Any]]:
    """Table of the summaries and numerical run metadata of jobs, by column."""
    rows = [
        store.read_manifest(job.stage, job.recipe).result.summary
        | _numbers(store.metadata(job.stage, job.recipe))
        for job in jobs
    ]
    return {name: plain([row.get(name) for row in rows]) for name in rows[0]}


def _numbers(metadata: Mapping[str, Any]) -> dict[str, float]:
    return {
        name: float(value) for name, value in metadata.items() if isinstance(value, int | float)
    }


def _now() -> int:
    return time.time_ns() // 1_000_000
