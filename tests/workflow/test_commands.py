"""Bundles and remotes beside the real Snakemake."""

import shlex
import shutil
import subprocess
import zipfile

import pytest

from tests.workflow.workspace import (
    EVERYTHING,
    QUIET,
    REPOSITORY,
    TABLE,
    Workspace,
    copy_repository,
    dummies_that_ran,
    with_dummies,
)

pytestmark = pytest.mark.workflow


def test_the_unpacked_project_has_the_plan_of_the_results(workspace, tmp_path):
    shutil.copy(REPOSITORY / "CITATION.cff", workspace.folder)
    (workspace.folder / ".gitignore").write_text("/artefacts\n/reports\n.snakemake\n__pycache__\n")
    workspace.computed("train.walking.iterations=5")
    for command in (["init", "-q"], ["add", "-A"]):
        subprocess.run(["git", "-C", workspace.folder, *command], check=True)
    done = workspace.slider("bundle", "table1")
    assert (done.returncode, done.stderr) == (0, "")
    printed = done.stdout.splitlines()[-1].removeprefix("unpacked, this has the results: ")
    with zipfile.ZipFile(workspace.folder / "reports" / "table1.crate.zip") as archive:
        archive.extractall(tmp_path / "unpacked")
    unpacked = Workspace(tmp_path / "unpacked")
    before = unpacked.stages()
    again = unpacked.command(["-m", *shlex.split(printed)])
    assert again.returncode == 0, again.stderr
    assert unpacked.table.read_text() == workspace.table.read_text()
    assert unpacked.stages() == before


@pytest.fixture(scope="module")
def giver(session_folder, tmp_path_factory) -> Workspace:
    """A pipeline of dummies that ran and pushed all to a folder beside it."""
    workspace = dummies_that_ran(session_folder, tmp_path_factory.mktemp("giver") / "once")
    pushed = workspace.slider("store", "push", str(workspace.folder / "remote"))
    assert pushed.stdout.startswith(f"push to {workspace.folder}/remote: {len(EVERYTHING)} sent (")
    return workspace


def test_the_pipeline_takes_what_it_needs_and_computes_what_is_damaged(giver, tmp_path):
    remote = giver.folder / "remote"
    table = giver.manifests("gait")[0]["result"]["files"]
    (remote / "files" / table["gait.txt"]["sha256"]).write_bytes(b"")
    taker = with_dummies(copy_repository(tmp_path / "taker"))
    run = taker.snakemake(TABLE, hydra=f"{QUIET} store.remote={remote}")
    assert run.returncode == 0, run.stderr
    assert f"damaged in {remote}: expected the content of gait.txt, found another" in run.stderr
    waiting = len(EVERYTHING) - 2  # in the index, for the damaged gait
    start = f"slider: from {remote}: "
    (line,) = [line for line in run.stderr.splitlines() if line.startswith(start)]
    for count in (" 1 taken", " 1 damaged", f" {waiting} of other inputs"):
        assert count in line
    assert taker.stages() == ["gait"]
    assert taker.table.read_text() == giver.table.read_text()


def test_no_remote_fails_a_run(giver):
    run = giver.snakemake(TABLE, "-n", hydra=f"{QUIET} store.remote=/nowhere")
    assert run.returncode == 0, run.stderr
    (line,) = [line for line in run.stderr.splitlines() if "slider: remote /nowhere: " in line]
    assert line.endswith("; what is missing is computed here")
