"""The real Snakemake with stages in miniature: reports, interruptions, messages, speed."""

import os
import signal
import time

import pytest

from tests.workflow.workspace import Workspace, copy_repository, with_dummies

pytestmark = pytest.mark.workflow

QUIET = "tracking.enabled=false"


@pytest.fixture
def workspace(tmp_path) -> Workspace:
    return with_dummies(copy_repository(tmp_path))


def test_the_table_follows_the_configuration_whatever_happens_to_it(workspace):
    workspace.computed(QUIET)
    first = workspace.table.read_text()
    workspace.computed(f"{QUIET} train.walking.iterations=5")
    second = workspace.table.read_text()
    assert first != second
    assert workspace.computed(QUIET) == []
    assert workspace.table.read_text() == first
    (workspace.folder / ".snakemake" / "metadata").rename(workspace.folder / "forgotten")
    assert workspace.computed(f"{QUIET} train.walking.iterations=5") == []
    assert workspace.table.read_text() == second
    workspace.table.write_text("edited by hand\n")
    assert workspace.computed(f"{QUIET} train.walking.iterations=5") == []
    assert workspace.table.read_text() == second
    workspace.table.unlink()
    for path in (workspace.artefacts / "table1").glob("*.json"):
        path.unlink()
    assert workspace.computed(f"{QUIET} train.walking.iterations=5") == []
    assert workspace.table.read_text() == second


def test_a_lost_object_is_computed_again(workspace):
    workspace.computed(QUIET)
    manifest = next(m for m in workspace.manifests("walking"))
    folder = workspace.artefacts / "objects" / manifest["object"][:2] / manifest["object"]
    for path in folder.iterdir():
        path.unlink()
    workspace.edit("src/slider/evaluation/stage.py", "policy}", "policy}!")
    found = workspace.computed(QUIET)
    assert found == ["evaluation", "evaluation", "table1", "walking"]
    assert workspace.slider("store", "verify").returncode == 0


def test_a_killed_job_is_resumed_and_marked(workspace):
    failed = workspace.snakemake("reports/table1.csv", hydra=QUIET, SUICIDE="1")
    assert failed.returncode == 1
    assert workspace.manifests("walking") == []
    assert not workspace.table.exists()
    assert workspace.computed(QUIET) == ["evaluation", "evaluation", "table1", "walking"]
    assert [manifest["resumed"] for manifest in workspace.manifests("walking")] == [True]
    assert workspace.slider("store", "gc", "--keep", "1").returncode == 0
    assert not (workspace.artefacts / "tmp").exists()
    assert workspace.computed(QUIET) == []


def test_a_killed_snakemake_wants_to_be_unlocked(workspace):
    slow = "    import time\n    time.sleep(30 if os.environ.get('SLOW') else 0)\n    checkpoint ="
    workspace.edit("src/slider/training/stage.py", "    checkpoint =", slow)
    process = workspace.start("reports/table1.csv", hydra=QUIET, SLOW="1")
    job = workspace.wait_for_job("walking")
    process.kill()
    process.wait()
    os.kill(job, signal.SIGKILL)
    locked = workspace.snakemake("reports/table1.csv", hydra=QUIET)
    assert locked.returncode == 1
    assert "--unlock" in locked.stderr
    assert workspace.snakemake("--unlock", hydra=QUIET).returncode == 0
    assert "walking" in workspace.computed(QUIET)
    assert workspace.computed(QUIET) == []


def test_a_failing_stage_shows_its_last_words(workspace):
    workspace.edit("src/slider/reports/table1.py", "    records", "    1 / 0\n    records")
    failed = workspace.snakemake("reports/table1.csv", hydra=QUIET)
    assert failed.returncode == 1
    assert "ZeroDivisionError: division by zero" in failed.stderr
    assert "artefacts/logs/table1/" in failed.stderr


def test_a_broken_database_of_runs_stops_nothing(workspace):
    (workspace.artefacts / "mlflow.db").mkdir(parents=True)
    done = workspace.snakemake("reports/table1.csv")
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
def test_a_mistake_is_one_line_and_status_1(workspace, setting, message):
    failed = workspace.command(["-m", "snakemake", "-n", "--config", setting])
    assert failed.returncode == 1
    lines = [line for line in failed.stderr.splitlines() if not line.startswith("Using workflow")]
    assert len(lines) == 1
    assert message in lines[0]


def test_without_a_target_the_table_is_wanted(workspace):
    dry = workspace.snakemake("-n", hydra=f"{QUIET} evaluation.trials=7")
    assert dry.returncode == 0
    assert "publish_table1" in dry.stdout + dry.stderr


def test_a_dry_run_and_a_run_with_nothing_to_do_are_fast(workspace):
    """125 gaits: 2.2 s and 2.1 s on two quiet cores; the bounds leave room for a busy machine."""
    assert workspace.snakemake("-n", "reports/table1.csv", hydra=QUIET).returncode == 0  # warm up
    grid = f"{QUIET} gait.grid.vx.start=0.0 gait.grid.vx.stop=1.2 gait.grid.vx.step=0.05"
    grid += " gait.grid.vy.start=-0.1 gait.grid.vy.stop=0.1 gait.grid.vy.step=0.05"
    start = time.monotonic()
    dry = workspace.snakemake("-n", "reports/table1.csv", hydra=grid)
    duration = time.monotonic() - start
    assert "125" in dry.stdout + dry.stderr
    assert duration < 8
    workspace.computed(grid)
    start = time.monotonic()
    assert workspace.computed(grid) == []
    assert time.monotonic() - start < 8
