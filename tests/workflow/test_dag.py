"""The real stages, tiny: what is computed when something changes.

All tests share one workspace and leave its sources and its table as they found them, so that each
starts from a finished pipeline; the recipes of earlier tests stay known to the store.
"""

import csv
import os
import signal
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from slider.reports.figures import FILES
from tests.workflow.workspace import (
    AFTER_STANDING,
    EVERYTHING,
    HOSTILE,
    PAGE,
    QUIET,
    TABLE,
    Workspace,
    copy_repository,
)
from tests.workflow.workspace import finished as finished_pipeline

pytestmark = pytest.mark.workflow

FOR_THE_PAGE = {"report", "video"}


@pytest.fixture(scope="module")
def first(session_folder) -> Workspace:
    """A pipeline that ran from nothing to its table and its page, once; nobody may change it."""
    workspace = finished_pipeline(session_folder)
    assert [job for job in workspace.stages() if job not in FOR_THE_PAGE] == EVERYTHING
    return workspace


@pytest.fixture(scope="module")
def finished(first, tmp_path_factory) -> Workspace:
    """A copy of it to work with."""
    return first.copy(tmp_path_factory.mktemp("dag") / "copy")


def restored(workspace: Workspace, path: str, old: str, new: str) -> list[str]:
    """Stages computed after an edit of the source, which is then taken back."""
    workspace.edit(path, old, new)
    computed = workspace.computed()
    workspace.edit(path, new, old)
    return computed


def test_ends_with_a_table_of_our_controller(finished):
    rows = list(csv.DictReader(finished.table.read_text().splitlines()))
    assert rows
    assert {"controller", "source", "command_velocity"} <= set(rows[0])
    assert list(finished.artefacts.glob("mlflow.db"))
    assert not list((finished.artefacts / "tmp").iterdir())


def test_a_hostile_folder_is_only_a_folder(first):
    """It has a space, quotes, a letter beyond ASCII and a command in its name."""
    assert first.folder.name == HOSTILE
    assert not list(first.folder.parent.rglob("pwned"))
    assert first.slider("store", "verify").returncode == 0
    assert (first.folder / PAGE).is_file()
    database = first.artefacts / "mlflow.db"
    with closing(sqlite3.connect(f"{database.as_uri()}?mode=ro", uri=True)) as connection:
        (runs,) = connection.execute("SELECT count(*) FROM runs").fetchone()
    assert runs > len(EVERYTHING) - 2


def test_computes_nothing_on_a_second_run(finished):
    assert finished.computed() == []


def test_the_figures_are_beside_the_way_to_the_table(finished):
    assert not list(finished.artefacts.glob("figures/*.json"))
    done = finished.snakemake("figures", hydra=QUIET)
    assert done.returncode == 0, done.stderr
    names = {path.name for path in (finished.folder / "reports/figures").iterdir()}
    assert names == {*FILES, "solve_times.svg", "solve_times.md"}
    assert finished.computed() == []
    shown = finished.slider("gait", "show", "--vx", "0.4")
    assert "Solve_Succeeded" in shown.stdout, shown.stderr


def test_computes_nothing_after_a_comment(finished):
    path = next((finished.folder / "src/slider/gait").glob("stage.py"))
    relative = str(path.relative_to(finished.folder))
    first_line = path.read_text().splitlines()[0]
    assert restored(finished, relative, first_line, f"# A comment.\n{first_line}") == []


def test_a_gait_value_makes_other_gaits_and_another_library(finished):
    """All that follows is computed anew as well: see test_machinery."""
    gaits, library = finished.objects("gait"), finished.objects("library")
    found = finished.computed("gait.posture.clearance=0.045", target="gait_library")
    assert found == ["gait", "gait", "library"]
    assert len(finished.objects("gait") - gaits) == 2
    assert len(finished.objects("library") - library) == 1


def test_computes_only_the_new_gaits_when_the_grid_grows(finished):
    found = finished.computed("gait.grid.vx.stop=0.6", target="gait_library")
    assert found == ["gait", "library"]


def test_a_refactoring_with_identical_results_stops_at_its_stage(finished):
    path = "src/slider/gait/stage.py"
    text = (finished.folder / path).read_text()
    (finished.folder / path).write_text(text + "\n\ndef unused() -> None:\n    pass\n")
    assert finished.computed() == ["gait", "gait"]
    (finished.folder / path).write_text(text)


def test_a_new_version_of_a_package_reaches_what_imports_it(finished, tmp_path: Path):
    info = tmp_path / "casadi-99.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: casadi\nVersion: 99.0\n")
    # Only the gaits import casadi; as their content stays the same, nothing follows.
    assert finished.computed(FIRST=str(tmp_path)) == ["gait", "gait"]


def test_a_value_of_a_training_that_is_killed_computes_it_and_what_follows(first, finished):
    """The kill leaves nothing half-written; the way back to the earlier value computes nothing."""
    before = finished.objects("walking")
    pipeline = finished.start(TABLE, hydra=f"train.walking.seed=7 {QUIET}")
    os.kill(finished.wait_for_job("walking"), signal.SIGKILL)
    assert pipeline.wait() == 1
    assert finished.objects("walking") == before
    assert finished.slider("store", "verify").returncode == 0
    assert finished.computed("train.walking.seed=7") == AFTER_STANDING
    assert finished.table.read_bytes() != first.table.read_bytes()
    assert finished.computed() == []
    assert finished.table.read_bytes() == first.table.read_bytes()


def test_same_seed_same_table(first, tmp_path: Path):
    again = copy_repository(tmp_path)
    assert again.computed() == EVERYTHING  # and nothing that only the page needs
    assert again.table.read_bytes() == first.table.read_bytes()
    for stage in ("gait", "library"):
        assert again.objects(stage) == first.objects(stage)
        assert again.objects(stage)
