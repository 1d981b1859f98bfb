"""The real Snakemake: which jobs run when something changes, and the table that they end with."""

import csv
import os
import re
import shutil
import sqlite3
import subprocess
from collections import Counter
from contextlib import closing
from pathlib import Path

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
    copy_repository,
    with_dummies,
)

pytestmark = pytest.mark.workflow

LONGER = "train.walking.iterations=5"
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


def test_ends_with_a_table_and_a_page_of_our_controller(real):
    """The folder has a space, quotes, a letter beyond ASCII and a command in its name."""
    of_the_page = ("figures", "report", "velocity_tracking", "video")
    assert [job for job in real.stages() if job not in of_the_page] == EVERYTHING
    rows = list(csv.DictReader(real.table.read_text().splitlines()))
    assert {"controller", "source", "speed"} <= set(rows[0])
    page = (real.folder / PAGE).read_text()
    assert "<script" not in page
    assert not re.findall(r'(?:src|href|poster)="(?!data:|#)', page)
    assert page.index("<img") < page.index("Success rate") < page.index("Mean velocity")
    assert real.folder.name == HOSTILE
    assert not list(real.folder.parent.rglob("pwned"))
    assert not list((real.artefacts / "objects" / "tmp").iterdir())
    assert real.slider("store", "verify").returncode == 0
    database = real.artefacts / "mlflow.db"
    with closing(sqlite3.connect(f"{database.as_uri()}?mode=ro", uri=True)) as connection:
        (runs,) = connection.execute("SELECT count(*) FROM runs").fetchone()
    assert runs > len(EVERYTHING) - 2


def test_targets_beside_the_way_to_the_table(real, tmp_path):
    """Checks of gaits wait for no training; what a study shares is computed once."""
    workspace = real.copy(tmp_path / "copy")
    shutil.copytree(REPOSITORY / "docs" / "policy", workspace.folder / "theirs")
    reports, study = workspace.folder / "reports", workspace.folder / "conf/study/mine.yaml"
    longer = "longer: {label: longer toe, overrides: [robot.geometry.toe=0.1]}"
    mine = f"run: [nominal, longer]\nvariants: {{{longer}}}\nscaling:\nspeeds: [0.4]\n"
    mine += "evaluation: {trials: 2, robots: 3}\n"  # as on the way to the table
    study.write_text(f"defaults: [sensitivity, _self_]\n{mine}")
    targets = "figures policy reports/verification.csv reports/mine.csv reports/gauge.csv"
    gauge = "+gauge.policies.theirs=theirs gauge.controllers=[theirs_onboard] gauge.axes=[delay]"
    stages = Counter(workspace.computed(f"verification.points=21 {gauge}", target=targets))
    once = {"gait", "evaluation", "study", "policy_import", "gauge_axis", "gauge"}
    assert {stage for stage in once if stages[stage] == 1} == once
    assert not {"standing", "walking", "table1"} & stages.keys()
    drawn = {path.name for path in (reports / "figures").iterdir()}
    assert set(FILES) <= drawn
    assert "2 gaits" in (reports / "verification.md").read_text()
    rows = csv.DictReader((reports / "verification.csv").open())
    assert [row["failed"] for row in rows] == ["", ""]
    rows = list(csv.DictReader((reports / "gauge.csv").open()))
    assert [row["axis"] for row in rows] == ["delay", "gauge number"]
    assert rows[0]["label"] == "theirs, onboard state"


def test_a_change_computes_what_depends_on_it(workspace):
    """What was computed once is never computed again."""
    first = workspace.table.read_bytes()
    assert workspace.computed(LONGER) == AFTER_STANDING
    assert workspace.table.read_bytes() != first
    workspace.table.write_text("edited by hand\n")
    (workspace.folder / ".snakemake" / "metadata").rename(workspace.folder / "forgotten")
    assert workspace.computed() == []
    assert workspace.table.read_bytes() == first

    refactored = workspace.folder / "src/slider/gait/stage.py"
    refactored.write_text("unused = 1\n" + refactored.read_text())
    assert workspace.computed() == ["gait", "gait"]  # which are the same, so nothing follows
    workspace.edit("src/slider/evaluation/stage.py", "} {policy}", "}!{policy}")
    assert workspace.computed() == ["evaluation", "evaluation", "table1"]
    assert workspace.table.read_bytes() != first
    assert workspace.slider("store", "verify").returncode == 0


def test_the_pipeline_takes_what_it_needs_and_computes_what_is_damaged(workspace, tmp_path):
    giver, remote = workspace, tmp_path / "remote"
    pushed = giver.slider("store", "push", str(remote))
    assert pushed.stdout.startswith(f"push to {remote}: {len(EVERYTHING)} uploaded (")
    result = giver.manifests("gait")[0]["result"]
    (remote / "files" / result["files"]["gait.txt"]["sha256"]).write_bytes(b"")
    taker = with_dummies(copy_repository(tmp_path / "taker"))
    run = taker.snakemake(TABLE, hydra=f"{QUIET} store.remote={remote}")
    assert run.returncode == 0, run.stderr
    assert f"damaged in {remote}: expected object {result['object'][:12]}, found " in run.stderr
    waiting = len(EVERYTHING) - 2  # in the index, for the damaged gait
    start = f"slider: from {remote}: "
    (line,) = [line for line in run.stderr.splitlines() if line.startswith(start)]
    for count in (" 1 fetched", " 1 damaged", f" {waiting} waiting for inputs"):
        assert count in line
    assert taker.stages() == ["gait"]
    assert taker.table.read_text() == giver.table.read_text()


def test_every_data_file_of_the_package_counts_as_one():
    """As git tracks it: of a kind that counts, and of a name that could be a module's."""
    command = ["git", "-C", REPOSITORY, "ls-files", "src"]
    tracked = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    names = [Path(name) for name in tracked if not name.endswith((".py", ".typed"))]
    assert names
    assert [name for name in names if name.suffix not in DATA or not name.stem.isidentifier()] == []


def test_a_failing_stage_shows_its_last_words(workspace):
    workspace.edit("src/slider/reports/table1.py", "    records", "    1 / 0\n    records")
    failed = workspace.snakemake(TABLE, hydra=QUIET)
    assert failed.returncode == 1
    assert "ZeroDivisionError: division by zero" in failed.stderr
    assert "artefacts/logs/table1/" in failed.stderr


def test_a_dry_run_and_a_run_with_nothing_to_do_are_fast(tmp_path):
    """125 gaits: 2.2 s and 2.1 s on a quiet machine; time of the processor, as it may be busy."""
    blank = with_dummies(copy_repository(tmp_path))
    grid = "gait.grid.vx.start=0.0 gait.grid.vx.stop=1.2 gait.grid.vx.step=0.05"
    grid += " gait.grid.vy.start=-0.1 gait.grid.vy.stop=0.1 gait.grid.vy.step=0.05"
    before = _processor_time()
    dry = blank.snakemake("-n", hydra=f"{grid} {QUIET}")  # the table is the default target
    assert _processor_time() - before < 8
    assert {"125", "publish_table1"} <= {*(dry.stdout + dry.stderr).split()}
    done = blank.command(["-c", RUN_ALL, f"experiment=test {grid} {QUIET}"])
    assert done.returncode == 0, done.stderr
    before = _processor_time()
    assert blank.computed(grid) == []
    assert _processor_time() - before < 8
    assert blank.table.is_file()


def _processor_time() -> float:
    """Of the processes that this one waited for [s]."""
    return sum(os.times()[2:4])
