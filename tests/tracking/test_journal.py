"""Journals of jobs, the writer that brings them to MLflow, and what a crash leaves behind."""

import logging
import os
import shutil
from pathlib import Path

import pytest
from mlflow import MlflowClient

from slider.tracking import journal as tracking
from slider.tracking.journal import FAILED, FINISHED, JournalTracker, current_session
from slider.tracking.mlflow_writer import follow

NOBODY = 2**22 + 1  # above the largest process id of Linux
RUN = {"name": "pipeline", "tags": {"plan": "p"}, "params": {"gait": {"nodes": 21}}}


@pytest.fixture(scope="module")
def database(tmp_path_factory) -> Path:
    """Without runs: MLflow takes seconds to lay one out."""
    path = tmp_path_factory.mktemp("mlflow") / "mlflow.db"
    MlflowClient(f"sqlite:///{path}").search_experiments()
    return path


@pytest.fixture
def artefacts(database: Path, tmp_path: Path, monkeypatch) -> Path:
    monkeypatch.setattr(tracking, "_spawn_writer", lambda *_: None)  # tests call follow()
    (tmp_path / "artefacts").mkdir()
    shutil.copy(database, tmp_path / "artefacts")
    return tmp_path / "artefacts"


def start(artefacts: Path, owner: int = os.getpid()) -> Path:
    apart = {"gait": "slider-gaits"}
    info = tracking.SessionInfo("slider", owner, {"git.dirty": "false"}, apart)
    return tracking.start(artefacts, info, **RUN).folder


def finish(artefacts: Path, folder: Path) -> None:
    JournalTracker(folder / "main.jsonl").end(FINISHED, {})
    follow(artefacts, folder.name)


def runs(artefacts: Path, name: str = "slider"):
    client = MlflowClient(f"sqlite:///{artefacts / 'mlflow.db'}")
    (experiment,) = client.search_experiments(filter_string=f"name = '{name}'")
    found = client.search_runs([experiment.experiment_id])
    return client, experiment, {run.info.run_name: run for run in found}


def test_one_parent_with_a_child_per_job(artefacts, tmp_path):
    folder = start(artefacts)
    assert current_session(artefacts) == folder
    job = JournalTracker(folder / "walking-1.jsonl")
    job.begin("walking", {"stage": "walking"})
    job.log_params({"train": {"seed": 1, "hidden": [32, 32]}})
    for step in range(1500):
        job.log_metrics({"reward": step / 2, "loss": float("nan")}, step)
    job.log_table({"vx": [0.0, 0.1], "cost": [1.0, float("inf")]}, "gaits")
    (tmp_path / "note.txt").write_text("note")
    job.log_file(tmp_path / "note.txt")
    (tmp_path / "note.txt").unlink()
    job.end(FINISHED, {"object": "abc"})
    broken = JournalTracker(folder / "evaluation-1.jsonl")
    broken.begin("evaluation", {"stage": "evaluation"})
    JournalTracker(folder / "main.jsonl").end(FINISHED, {})
    tracking.stop(artefacts)
    assert current_session(artefacts) is None
    follow(artefacts, folder.name)
    client, _, found = runs(artefacts)
    assert not folder.exists()
    states = {name: run.info.status for name, run in found.items()}
    assert states == {"pipeline": FINISHED, "walking": FINISHED, "evaluation": FAILED}
    walking = found["walking"]
    tags = {"mlflow.parentRunId": found["pipeline"].info.run_id, "object": "abc"}
    assert walking.data.tags.items() >= (tags | {"git.dirty": "false"}).items()
    assert walking.data.params == {"train.seed": "1", "train.hidden": "[32, 32]"}
    assert found["pipeline"].data.params == {"gait.nodes": "21"}
    assert len(client.get_metric_history(walking.info.run_id, "reward")) == 1500
    assert walking.data.metrics["reward"] == 749.5
    names = {item.path for item in client.list_artifacts(walking.info.run_id)}
    assert names == {"gaits.json", "note.txt"}


def test_many_runs_stand_in_an_experiment_of_their_own(artefacts):
    """Gaits: their library links to them, and they name the pipeline's run."""
    folder = start(artefacts)
    for name, stage, needs in (("gait 0.2", "gait", []), ("gait library", "library", ["gait"])):
        job = JournalTracker(folder / f"{stage}-1.jsonl")
        job.begin(name, {"stage": stage}, needs)
        job.end(FINISHED, {}, "Result.")
    finish(artefacts, folder)
    found = runs(artefacts)[-1]
    assert set(found) == {"pipeline", "gait library"}
    _, experiment, apart = runs(artefacts, "slider-gaits")
    assert set(apart) == {"gait 0.2"}
    tags = apart["gait 0.2"].data.tags
    assert tags["pipeline"] == found["pipeline"].info.run_id
    assert "mlflow.parentRunId" not in tags
    assert experiment.tags["mlflow.experimentKind"] == "custom_model_development"
    note = found["gait library"].data.tags["mlflow.note.content"]
    assert f"(#/experiments/{experiment.experiment_id}/runs" in note
    assert note.endswith("\n\nResult.")


def test_runs_of_a_killed_pipeline_end_as_failed_with_the_next(artefacts):
    killed = start(artefacts, NOBODY)
    JournalTracker(killed / "walking-1.jsonl").begin("walking", {})
    (killed / "walking-1.jsonl").open("a").write('{"event": "metr')  # cut short
    killed = killed.rename(killed.with_name("20000101T000000-1"))
    finish(artefacts, start(artefacts))
    client, _, found = runs(artefacts)
    assert found["walking"].info.status == FAILED
    pipelines = client.search_runs(["1"], "attributes.run_name = 'pipeline'")
    assert sorted(run.info.status for run in pipelines) == [FAILED, FINISHED]
    assert not killed.exists()


def test_unreadable_sessions_do_not_hold_up_the_next(artefacts):
    broken = []
    for content in (b"{}", b"[]", b"\xff"):
        broken.append(artefacts / "tracking" / f"20000101T000000-{len(broken)}")
        broken[-1].mkdir(parents=True)
        (broken[-1] / "session.json").write_bytes(content)
    finish(artefacts, start(artefacts))
    assert runs(artefacts)[-1]["pipeline"].info.status == FINISHED
    assert not any(session.exists() for session in broken)


def test_a_broken_tracker_is_one_warning(tmp_path, caplog):
    tracker = JournalTracker(tmp_path / "no" / "folder.jsonl")
    with caplog.at_level(logging.WARNING):
        tracker.log_metrics({"reward": 1.0}, 0)
        tracker.log_file(tmp_path / "nothing")
        tracker.log_table({"x": [object()]}, "x")
    assert len(caplog.records) == 1


def test_no_session_no_journal(tmp_path):
    assert current_session(tmp_path) is None
    (tmp_path / "tracking").mkdir()
    (tmp_path / "tracking" / "current").write_bytes(b"\xff")
    assert current_session(tmp_path) is None
