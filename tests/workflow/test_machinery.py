"""The real Snakemake with stages in miniature: reports, interruptions, messages, speed."""

import json
import os
import resource
import signal
from collections.abc import Callable
from functools import cache
from typing import Any

import pytest

from tests.workflow.workspace import (
    AFTER_STANDING,
    EVERYTHING,
    QUIET,
    TABLE,
    Workspace,
    copy_repository,
    dummies_that_ran,
    with_dummies,
)

pytestmark = pytest.mark.workflow

RUN_ALL = """
import sys
from pathlib import Path
from pipeline.entry import open_pipeline
from slider.artefacts.plan import build_plan
from slider.artefacts.runner import Runner

opened = open_pipeline({"hydra": sys.argv[1]}, Path("conf"))
target = opened.plan.jobs[opened.plan.targets["table1"]]
for job in build_plan({"table1": target}).jobs.values():
    Runner(opened.store).run(job)
"""
LONGER = f"{QUIET} train.walking.iterations=5"


@pytest.fixture(scope="module")
def once(session_folder, tmp_path_factory) -> Workspace:
    return dummies_that_ran(session_folder, tmp_path_factory.mktemp("machinery") / "once")


@pytest.fixture
def workspace(once, tmp_path) -> Workspace:
    return once.copy(tmp_path / "copy")


@pytest.fixture
def blank(tmp_path) -> Workspace:
    """Dummies of which none ran."""
    return with_dummies(copy_repository(tmp_path))


def test_the_table_follows_the_configuration_whatever_happens_to_it(workspace):
    first = workspace.table.read_text()
    assert workspace.computed(LONGER) == AFTER_STANDING
    second = workspace.table.read_text()
    assert first != second
    assert workspace.computed() == []
    assert workspace.table.read_text() == first
    (workspace.folder / ".snakemake" / "metadata").rename(workspace.folder / "forgotten")
    assert workspace.computed(LONGER) == []
    assert workspace.table.read_text() == second
    workspace.table.write_text("edited by hand\n")
    assert workspace.computed(LONGER) == []
    assert workspace.table.read_text() == second
    workspace.table.unlink()
    for path in (workspace.artefacts / "table1").glob("*.json"):
        path.unlink()
    assert workspace.computed(LONGER) == []
    assert workspace.table.read_text() == second


def test_computes_everything_after_a_gait_value(workspace):
    assert workspace.computed("gait.nodes=31") == EVERYTHING


def test_a_lost_object_is_computed_again(workspace):
    manifest = next(m for m in workspace.manifests("walking"))
    folder = workspace.artefacts / "objects" / manifest["object"][:2] / manifest["object"]
    for path in folder.iterdir():
        path.unlink()
    workspace.edit("src/slider/evaluation/stage.py", "policy}", "policy}!")
    assert workspace.computed() == AFTER_STANDING
    assert workspace.slider("store", "verify").returncode == 0


@pytest.fixture(scope="module")
def whole(once, tmp_path_factory) -> Callable[[str], str]:
    """The table with overrides, computed from what is undamaged."""

    @cache
    def table(overrides: str) -> str:
        workspace = once.copy(tmp_path_factory.mktemp("whole") / "copy")
        workspace.computed(overrides)
        return workspace.table.read_text()

    return table


MORE = "evaluation.commands=[0.2,0.4,0.3]"
ANOTHER_SEED = "train.walking.seed=3"


@pytest.mark.parametrize(
    ("stage", "further", "verified"),
    [
        ("evaluation", MORE, True),
        ("standing", ANOTHER_SEED, True),
        ("library", ANOTHER_SEED, False),
    ],
)
def test_no_table_is_made_of_a_changed_digit(workspace, once, whole, stage, further, verified):
    """Whatever is asked for next, with or without ``slider store verify`` before."""
    change_a_digit(workspace, stage)
    assert not verified or workspace.slider("store", "verify").returncode == 1
    assert stage in workspace.computed(further)
    assert workspace.table.read_text() == whole(further)
    workspace.computed()
    assert workspace.table.read_text() == once.table.read_text()
    assert workspace.slider("store", "verify").returncode == 0


def change_a_digit(workspace: Workspace, stage: str) -> None:
    """Of a stage's first result, as a failing disk does it: size and times stay."""
    digest = sorted(workspace.objects(stage))[0]
    path = next((workspace.artefacts / "objects" / digest[:2] / digest).iterdir())
    times, text = path.stat(), path.read_text()
    digit = next(character for character in text if character in "1234")
    path.chmod(0o644)
    path.write_text(text.replace(digit, "7", 1))
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def test_verify_drops_a_table_that_was_made_of_a_changed_digit(workspace, once):
    """By an earlier version, which checked no input and noted none."""
    (table,) = workspace.objects("table1")
    change_a_digit(workspace, "evaluation")
    for path in workspace.artefacts.glob("**/*.json"):
        if path.parent.parent.name == "index" or path.parent.name == "table1":
            values = json.loads(path.read_text())
            values.pop("input_objects", None)
            path.write_text(json.dumps(values))
    dropped = workspace.slider("store", "verify")
    assert dropped.returncode == 1
    assert "computed from a damaged object" in dropped.stdout
    assert workspace.manifests("table1") == []
    assert workspace.computed() == ["evaluation", "table1"]
    assert workspace.objects("table1") == {table}
    assert workspace.slider("store", "verify").returncode == 0


def test_a_killed_job_is_resumed_and_marked(workspace):
    before, table = workspace.manifests("walking"), workspace.table.read_text()
    failed = workspace.snakemake(TABLE, hydra=LONGER, SUICIDE="1")
    assert failed.returncode == 1
    assert workspace.manifests("walking") == before
    assert workspace.table.read_text() == table
    assert workspace.computed(LONGER) == AFTER_STANDING
    resumed = [manifest.get("resumed", False) for manifest in workspace.manifests("walking")]
    assert sorted(resumed) == [False, True]
    assert workspace.slider("store", "gc", "--keep", "1").returncode == 0
    assert [manifest.get("resumed") for manifest in workspace.manifests("walking")] == [True]
    assert not (workspace.artefacts / "tmp").exists()
    assert workspace.computed(LONGER) == []


def test_a_killed_snakemake_wants_to_be_unlocked(workspace):
    slow = "    import time\n    time.sleep(30 if os.environ.get('SLOW') else 0)\n    checkpoint ="
    workspace.edit("src/slider/training/stage.py", "    checkpoint =", slow)
    process = workspace.start(TABLE, hydra=QUIET, SLOW="1")
    job = workspace.wait_for_job("walking")
    process.kill()
    process.wait()
    os.kill(job, signal.SIGKILL)
    locked = workspace.snakemake(TABLE, hydra=QUIET)
    assert locked.returncode == 1
    assert "--unlock" in locked.stderr
    assert workspace.snakemake("--unlock", hydra=QUIET).returncode == 0
    assert "walking" in workspace.computed()
    assert workspace.computed() == []


def test_a_failing_stage_shows_its_last_words(workspace):
    workspace.edit("src/slider/reports/table1.py", "    records", "    1 / 0\n    records")
    failed = workspace.snakemake(TABLE, hydra=QUIET)
    assert failed.returncode == 1
    assert "ZeroDivisionError: division by zero" in failed.stderr
    assert "artefacts/logs/table1/" in failed.stderr


def test_a_broken_database_of_runs_stops_nothing(workspace):
    (workspace.artefacts / "mlflow.db").mkdir(parents=True)
    done = workspace.snakemake(TABLE, hydra="train.walking.iterations=5")
    assert done.returncode == 0
    assert "MLflow misses part of this run: see artefacts/logs/tracking.log" in done.stderr


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("hydra=gait.nods=3", "did you mean 'gait.nodes'?"),
        ("hydra=3", "expected text of the form key=value, found 3"),
        ("hydar=gait.nodes=3", "unknown --config name 'hydar'"),
    ],
)
def test_a_mistake_is_one_line_and_status_1(blank, setting, message):
    failed = blank.command(["-m", "snakemake", "-n", "--config", setting])
    assert failed.returncode == 1
    lines = [line for line in failed.stderr.splitlines() if not line.startswith("Using workflow")]
    assert len(lines) == 1
    assert message in lines[0]


def test_without_a_target_the_table_is_wanted(blank):
    dry = blank.snakemake("-n", hydra=f"{QUIET} evaluation.trials=7")
    assert dry.returncode == 0
    assert "publish_table1" in dry.stdout + dry.stderr


def test_a_dry_run_and_a_run_with_nothing_to_do_are_fast(blank):
    """125 gaits: 2.2 s and 2.1 s on a quiet machine; time of the processor, as it may be busy."""
    assert blank.snakemake("-n", TABLE, hydra=QUIET).returncode == 0  # warm up
    grid = "gait.grid.vx.start=0.0 gait.grid.vx.stop=1.2 gait.grid.vx.step=0.05"
    grid += " gait.grid.vy.start=-0.1 gait.grid.vy.stop=0.1 gait.grid.vy.step=0.05"
    dry, seconds = timed(lambda: blank.snakemake("-n", TABLE, hydra=f"{grid} {QUIET}"))
    assert "125" in dry.stdout + dry.stderr
    assert seconds < 8
    done = blank.command(["-c", RUN_ALL, f"experiment=test {grid} {QUIET}"])
    assert done.returncode == 0, done.stderr
    assert len(blank.manifests("gait")) == 125
    computed, seconds = timed(lambda: blank.computed(grid))
    assert computed == []
    assert blank.table.is_file()
    assert seconds < 8


def timed(run: Callable[[], Any]) -> tuple[Any, float]:
    """What it returns and the processor time of the processes that it waited for [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = run()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return result, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
