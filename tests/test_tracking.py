"""Runs in MLflow: what a pipeline brings there, and what a killed one leaves."""

import logging
import shutil
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import pytest
from mlflow import MlflowClient

from slider.artefacts.plan import JobSpec
from slider.artefacts.runner import MetricsFile
from slider.artefacts.store import Store
from slider.tracking import FAILED, FINISHED, Tracking
from tests.artefacts.samples import GAITS, LIBRARY, PLAN, TABLE, compute

RUNNING = "RUNNING"


@pytest.fixture(scope="module")
def database(tmp_path_factory) -> Path:
    """Without runs: MLflow takes seconds to lay one out."""
    path = tmp_path_factory.mktemp("mlflow") / "mlflow.db"
    MlflowClient(f"sqlite:///{path}").search_experiments()
    return path


@pytest.fixture
def tracked(store: Store, database: Path) -> Store:
    store.root.mkdir()
    shutil.copy(database, store.root)
    return store


def start(store: Store, name: str = "pipeline") -> Tracking:
    common, params = {"git.dirty": "false"}, {"gait": {"nodes": 21}}
    return Tracking(store, PLAN, "slider", name, params, {"plan": "p"}, common)


def run(tracking: Tracking, store: Store, job: JobSpec, computed: bool = True, **texts) -> None:
    """A job that starts, leaves a result and ends."""
    tracking.began(job.recipe)
    end(tracking, store, job, computed, **texts)


def end(tracking: Tracking, store: Store, job: JobSpec, computed: bool = True, **texts) -> None:
    ended = datetime.now(UTC).isoformat()
    facts = {"computed": computed, "ended": ended, "wall_s": 2.5, "solve_cpu": 0.5}
    compute(store, job, "", {"n": 1.5, "status": "good", "rate": {"hzd": 1.0}}, facts, **texts)
    tracking.ended(job.recipe)


def runs(store: Store, name: str = "slider"):
    client = MlflowClient(f"sqlite:///{store.root / 'mlflow.db'}")
    experiment = client.get_experiment_by_name(name)
    found = client.search_runs([experiment.experiment_id]) if experiment else []
    return client, experiment, {run.info.run_name: run for run in found}


def states(store: Store, name: str = "slider") -> dict[str, str]:
    return {name: run.info.status for name, run in runs(store, name)[-1].items()}


def wait_for(condition) -> None:
    deadline = time.monotonic() + 120
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.2)


def test_a_pipeline_is_a_run_and_each_computed_job_a_child(tracked):
    tracking = start(tracked)
    for job in GAITS:  # no runs
        run(tracking, tracked, job)
    tracking.began(LIBRARY.recipe)
    log = MetricsFile(tracked.metrics_path("library", LIBRARY.recipe))
    for step in range(1500):
        log({"reward": step / 2, "loss": float("nan")}, step)
    wait_for(lambda: states(tracked).get("library") == RUNNING)  # before its end
    log({"reward": 750.0}, 1500)
    end(tracking, tracked, LIBRARY, table="a,b\n")
    tracking.began(TABLE.recipe)
    tracking.ended(TABLE.recipe, succeeded=False)
    tracking.finish(succeeded=True)
    assert tracking.error is None

    client, experiment, found = runs(tracked)
    assert states(tracked) == {"pipeline": FINISHED, "library": FINISHED, "table": FAILED}
    main, library = found["pipeline"], found["library"]
    assert main.data.params == {"gait.nodes": "21"}
    assert main.data.tags.items() >= {"plan": "p", "git.dirty": "false"}.items()
    manifest = tracked.read_manifest("library", LIBRARY.recipe)
    path = f"objects/{manifest.result.object[:2]}/{manifest.result.object}"
    tags = {"mlflow.parentRunId": main.info.run_id, "git.dirty": "false", "stage": "library"}
    tags |= {"recipe": LIBRARY.recipe, "object": manifest.result.object, "object.path": path}
    assert library.data.tags.items() >= tags.items()
    history = client.get_metric_history(library.info.run_id, "reward")
    assert [(one.step, one.value) for one in history] == [(k, k / 2) for k in range(1501)]
    numbers = {"n": 1.5, "rate/hzd": 1.0, "run/wall_s": 2.5, "run/solve_cpu": 0.5}
    assert library.data.metrics.items() >= numbers.items()
    names = {item.path for item in client.list_artifacts(library.info.run_id)}
    assert names == {"gaits.json", "table.csv"}

    assert experiment.tags["mlflow.experimentKind"] == "custom_model_development"


def test_runs_of_a_killed_pipeline_end_with_the_next_and_those_of_a_living_one_go_on(tracked):
    """Whose process numbers mean nothing here: it may run in a container."""
    for job in GAITS:
        compute(tracked, job)
    living = start(tracked, "living")
    living.began(LIBRARY.recipe)
    MetricsFile(tracked.metrics_path("library", LIBRARY.recipe))({"reward": 1.0}, 0)
    wait_for(lambda: states(tracked).get("library") == RUNNING)
    client, experiment, _ = runs(tracked)
    place = experiment.experiment_id
    killed = client.create_run(place, tags={"plan": "q"}, run_name="killed").info.run_id
    client.create_run(place, tags={"mlflow.parentRunId": killed}, run_name="walking")
    client.create_run(place, run_name="somebody's own")
    start(tracked, "next").finish(succeeded=False)
    found = {"living": RUNNING, "library": RUNNING, "next": FAILED, "somebody's own": RUNNING}
    assert states(tracked) == found | {"killed": FAILED, "walking": FAILED}
    end(living, tracked, LIBRARY)
    living.finish(succeeded=True)
    assert states(tracked).items() >= {"living": FINISHED, "library": FINISHED}.items()
    assert living.error is None


def test_what_is_missing_is_said_and_the_rest_is_there(tracked):
    for job in GAITS:
        compute(tracked, job)
    tracking = start(tracked)
    tracking.began(LIBRARY.recipe)
    tracked.metrics_path("library", LIBRARY.recipe).parent.mkdir(parents=True)
    tracked.metrics_path("library", LIBRARY.recipe).write_bytes(b"\xff\n")
    end(tracking, tracked, LIBRARY)
    run(tracking, tracked, TABLE, computed=False)  # no run
    tracking.finish(succeeded=True)
    assert isinstance(tracking.error, ValueError)
    assert states(tracked) == {"pipeline": FINISHED, "library": FINISHED}


def test_metrics_that_cannot_be_written_are_one_warning(tmp_path, caplog):
    (tmp_path / "file").touch()
    log = MetricsFile(tmp_path / "file" / "metrics.jsonl")
    with caplog.at_level(logging.WARNING):
        log({"reward": 1.0}, 0)
        log({"reward": 2.0}, 1)
    assert len(caplog.records) == 1


def test_planning_does_not_wait_for_mlflow():
    code = "import sys, pipeline.entry, pipeline.console; print(*sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "pipeline.entry" in found.stdout.split()
    assert "mlflow" not in found.stdout.split()
