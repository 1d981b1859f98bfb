"""The real Snakemake: which jobs run when something changes, and the table that they end with."""

import csv
import json
import os
import py_compile
import resource
import shutil
import sqlite3
from contextlib import closing

import pytest

from slider.artefacts.recipe import DATA
from slider.reports.figures import FILES
from tests.workflow.workspace import (
    AFTER_STANDING,
    EVERYTHING,
    HOSTILE,
    PAGE,
    QUIET,
    REPOSITORY,
    TABLE,
    Workspace,
    copy_repository,
    dummies_that_ran,
    finished,
    with_dummies,
)

pytestmark = pytest.mark.workflow

LONGER = "train.walking.iterations=5"
GAIT, EVALUATION = (f"src/slider/{name}/stage.py" for name in ("gait", "evaluation"))
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


# The real stages, tiny.


@pytest.fixture(scope="module")
def real(session_folder) -> Workspace:
    """A pipeline that ran from nothing to its table and its page, once; nobody may change it."""
    return finished(session_folder)


def test_ends_with_a_table_and_a_page_of_our_controller(real):
    """The folder has a space, quotes, a letter beyond ASCII and a command in its name."""
    assert [job for job in real.stages() if job not in ("figures", "report", "video")] == EVERYTHING
    rows = list(csv.DictReader(real.table.read_text().splitlines()))
    assert {"controller", "source", "speed"} <= set(rows[0])
    assert (real.folder / PAGE).is_file()
    assert real.folder.name == HOSTILE
    assert not list(real.folder.parent.rglob("pwned"))
    assert not list((real.artefacts / "tmp").iterdir())
    assert real.slider("store", "verify").returncode == 0
    database = real.artefacts / "mlflow.db"
    with closing(sqlite3.connect(f"{database.as_uri()}?mode=ro", uri=True)) as connection:
        (runs,) = connection.execute("SELECT count(*) FROM runs").fetchone()
    assert runs > len(EVERYTHING) - 2


def test_same_seed_same_table(real, tmp_path):
    """Whatever the home folder is and MPLBACKEND, MUJOCO_GL say, which Table 1 does not need."""
    again = copy_repository(tmp_path)
    hostile = {"HOME": "/proc/nobody", "MPLBACKEND": "none", "MUJOCO_GL": "none"}
    assert again.computed(**hostile) == EVERYTHING  # and nothing that only the page needs
    assert again.table.read_bytes() == real.table.read_bytes()
    for stage in ("gait", "library", "evaluation", "table1"):
        assert again.objects(stage) == real.objects(stage), stage


def test_what_is_beside_the_way_to_the_table(real, tmp_path):
    """Figures, stability and checks of gaits are targets of their own and wait for no training."""
    workspace = real.copy(tmp_path / "copy")
    targets = ("figures", "reports/stability.csv", "reports/verification.csv")
    short = "verification.replay.steps=2 verification.points=21"
    done = workspace.snakemake(*targets, hydra=f"{short} {QUIET}")
    assert done.returncode == 0, done.stderr
    for stage in ("figures", "stability_gaits", "return_maps", "verification_gaits"):
        (manifest,) = workspace.manifests(stage)
        assert {"library"} <= set(manifest["inputs"]) <= {"library", "gaits"}
    reports = workspace.folder / "reports"
    names = {path.name for path in (reports / "figures").iterdir()}
    assert names == {*FILES, "solve_times.svg", "solve_times.md"}
    rows = list(csv.DictReader((reports / "stability.csv").read_text().splitlines()))
    assert [float(row["vx"]) for row in rows] == [0.2, 0.4]
    assert all(float(row["closed_spectral_radius"]) < 1 for row in rows)
    verdict = json.loads((reports / "verification.json").read_text())
    assert (verdict["passed"], verdict["gaits"]) == (True, 2)
    assert "Solve_Succeeded" in workspace.slider("gait", "show", "--vx", "0.4").stdout

    strict = f"{short} verification.bounds.roll_end=1e-12"
    hydra = f"{strict} verification.on_failure=error {QUIET}"
    failing = workspace.snakemake("reports/verification.csv", hydra=hydra)
    assert failing.returncode == 1
    assert "gait (0.2, 0) m/s, roll_end: expected ≤ 1e-12 rad" in failing.stderr
    assert workspace.computed(strict, target="reports/verification.csv") == ["verification"]


def test_the_gauge_and_the_export_of_the_policy_in_it(real, tmp_path):
    """Another axis computes itself alone; a policy that changed computes its axes again."""
    workspace = real.copy(tmp_path / "copy")
    target, mine = "reports/gauge.csv", "gauge.controllers=[mine_onboard]"
    assert workspace.computed(target=target) == ["gauge", *["gauge_axis"] * 3]
    more = "gauge.axes=[slope_up,delay,push,friction]"
    assert workspace.computed(more, target=target) == ["gauge", "gauge_axis"]
    assert (workspace.folder / "reports" / "figures" / "gauge.svg").is_file()
    missing = workspace.snakemake("-n", target, hydra=f"{mine} +gauge.policies.mine=nowhere")
    expected = "a folder with policy.onnx, policy.json, reference.npy"
    assert f"policies.mine: expected {expected}, found no nowhere/policy.onnx" in missing.stderr
    assert "Traceback" not in missing.stderr
    assert workspace.snakemake("policy", hydra=QUIET).returncode == 0
    exported = f"{mine} +gauge.policies.mine=reports/policy gauge.axes=[delay]"
    assert workspace.computed(exported, target=target) == ["gauge", "gauge_axis", "policy_import"]
    rows = list(csv.DictReader((workspace.folder / target).read_text().splitlines()))
    assert [row["axis"] for row in rows] == ["delay", "gauge number"]
    assert rows[0]["label"] == "mine, onboard state"
    layout = workspace.folder / "reports" / "policy" / "policy.json"
    layout.chmod(0o644)
    layout.write_text(layout.read_text() + "\n")
    assert workspace.computed(exported, target=target) == ["gauge_axis", "policy_import"]


def test_a_search_for_the_baselines_settings(real, tmp_path):
    workspace, target = real.copy(tmp_path / "copy"), "reports/baseline_tuning.csv"
    small = "~tuning.spaces.hzd"
    assert workspace.computed(small, target=target) == ["baseline_tuning", "tuning"]
    rows = list(csv.DictReader((workspace.folder / target).read_text().splitlines()))
    assert [float(row["trial"]) for row in rows] == [0, 1, 2]
    assert float(rows[0]["step.apex"]) == 0.07
    assert len({row["step.apex"] for row in rows}) == 3
    assert workspace.computed(small, target=target) == []


# Stages in miniature.


@pytest.fixture(scope="module")
def once(session_folder, tmp_path_factory) -> Workspace:
    return dummies_that_ran(session_folder, tmp_path_factory.mktemp("dag") / "once")


@pytest.fixture
def workspace(once, tmp_path) -> Workspace:
    return once.copy(tmp_path / "copy")


@pytest.fixture
def blank(tmp_path) -> Workspace:
    """Dummies of which none ran."""
    return with_dummies(copy_repository(tmp_path))


@pytest.mark.parametrize(
    ("override", "stages"),
    [
        ("gait.nodes=31", EVERYTHING),
        ("gait.grid.vx.stop=0.6", [*EVERYTHING[:3], *EVERYTHING[4:]]),
        (LONGER, AFTER_STANDING),
        ("evaluation.speeds=[0.2,0.4,0.3]", ["evaluation", "table1"]),
        ("resources.threads=1", []),
    ],
)
def test_a_value_computes_what_depends_on_it(workspace, override, stages):
    """The way back to the earlier value computes nothing and restores the table."""
    first = workspace.table.read_bytes()
    assert workspace.computed(override) == stages
    assert (workspace.table.read_bytes() != first) == bool(stages)
    assert workspace.computed() == []
    assert workspace.table.read_bytes() == first


def comment(workspace: Workspace) -> None:
    prepend(workspace, GAIT, "# A comment.\n")


def refactoring(workspace: Workspace) -> None:
    """The gaits stay the same, so nothing follows."""
    prepend(workspace, GAIT, "unused = 1\n")


def another_evaluation(workspace: Workspace) -> None:
    workspace.edit(EVALUATION, "policy}", "policy}!")


def of_the_same_size_and_time(workspace: Workspace) -> None:
    """As out of an archive whose files have one date; bytecode of the module before is there."""
    path = workspace.folder / EVALUATION
    before = path.stat()
    mode = py_compile.PycInvalidationMode.TIMESTAMP
    py_compile.compile(str(path), invalidation_mode=mode)
    workspace.edit(EVALUATION, "} {policy}", "}!{policy}")
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert path.stat().st_size == before.st_size


def new_version(workspace: Workspace) -> None:
    """Only the gaits import casadi."""
    info = workspace.folder / "src" / "casadi-99.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: casadi\nVersion: 99.0\n")


def foreign_path(workspace: Workspace) -> None:
    """A sourced ROS: PYTHONPATH with another casadi."""
    new_version(workspace)
    info = workspace.folder / "src" / "casadi-99.0.dist-info"
    shutil.move(info, workspace.folder / "conf")


def litter(workspace: Workspace) -> None:
    for name in (".DS_Store", "Thumbs.db", "stage.py.orig"):
        (workspace.folder / "src" / "slider" / "gait" / name).write_text("")


def test_every_data_file_of_the_package_counts_as_one():
    kinds = {path.suffix for path in (REPOSITORY / "src" / "slider").rglob("*.*")}
    assert kinds - {".py", ".pyc", ".typed", ".machine", ".json"} <= {*DATA}


def lost_manifests(workspace: Workspace) -> None:
    for path in (workspace.artefacts / "table1").glob("*.json"):
        path.unlink()
    workspace.table.unlink()


def edited_table(workspace: Workspace) -> None:
    workspace.table.write_text("edited by hand\n")
    (workspace.folder / ".snakemake" / "metadata").rename(workspace.folder / "forgotten")


def prepend(workspace: Workspace, path: str, text: str) -> None:
    file = workspace.folder / path
    file.write_text(text + file.read_text())


@pytest.mark.parametrize(
    ("change", "stages"),
    [
        (comment, []),
        (refactoring, ["gait", "gait"]),
        (another_evaluation, ["evaluation", "evaluation", "table1"]),
        (of_the_same_size_and_time, ["evaluation", "evaluation", "table1"]),
        (new_version, ["gait", "gait"]),
        (foreign_path, []),
        (litter, []),
        (lost_manifests, []),
        (edited_table, []),
    ],
)
def test_a_change_computes_what_depends_on_it(workspace, change, stages):
    first = workspace.table.read_text()
    change(workspace)
    path = f"{workspace.folder / 'src'}:{workspace.folder / 'conf'}"
    assert workspace.computed(PYTHONPATH=path) == stages
    others = (another_evaluation, of_the_same_size_and_time)
    assert (workspace.table.read_text() == first) == (change not in others)
    assert workspace.slider("store", "verify").returncode == 0


def test_a_failing_stage_shows_its_last_words(workspace):
    workspace.edit("src/slider/reports/table1.py", "    records", "    1 / 0\n    records")
    failed = workspace.snakemake(TABLE, hydra=QUIET)
    assert failed.returncode == 1
    assert "ZeroDivisionError: division by zero" in failed.stderr
    assert "artefacts/logs/table1/" in failed.stderr


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("hydra=gait.nods=3", "did you mean 'gait.nodes'?"),
        ("hydra=3", "expected text of the form key=value, found 3"),
        ("hydar=gait.nodes=3", "unknown --config name 'hydar'"),
        ("hydra=", "expected Python with docstrings, found PYTHONOPTIMIZE=2"),
    ],
)
def test_a_mistake_is_one_line_and_status_1(once, setting, message):
    environment = {"PYTHONOPTIMIZE": "2"} if "PYTHONOPTIMIZE" in message else {}
    failed = once.command(["-m", "snakemake", "-n", "--config", setting], **environment)
    assert failed.returncode == 1
    (line,) = [line for line in failed.stderr.splitlines() if not line.startswith("Using workflow")]
    assert message in line


def test_a_store_on_a_disk_that_is_not_mounted_is_one_line(blank, tmp_path):
    (blank.folder / "artefacts").symlink_to(tmp_path / "disk")
    dry = blank.snakemake("-n", hydra=QUIET)
    assert dry.returncode == 1
    assert f"expected a folder at artefacts, found a link to {tmp_path}/disk\n" in dry.stderr


def test_a_dry_run_and_a_run_with_nothing_to_do_are_fast(blank):
    """125 gaits: 2.2 s and 2.1 s on a quiet machine; time of the processor, as it may be busy."""
    grid = "gait.grid.vx.start=0.0 gait.grid.vx.stop=1.2 gait.grid.vx.step=0.05"
    grid += " gait.grid.vy.start=-0.1 gait.grid.vy.stop=0.1 gait.grid.vy.step=0.05"
    before = _processor_time()
    dry = blank.snakemake("-n", hydra=f"{grid} {QUIET}")  # the table is the default target
    assert _processor_time() - before < 8
    assert "125" in dry.stdout + dry.stderr
    assert "publish_table1" in dry.stdout + dry.stderr
    done = blank.command(["-c", RUN_ALL, f"experiment=test {grid} {QUIET}"])
    assert done.returncode == 0, done.stderr
    before = _processor_time()
    assert blank.computed(grid) == []
    assert _processor_time() - before < 8
    assert blank.table.is_file()


def _processor_time() -> float:
    """Of the processes that this one waited for [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
