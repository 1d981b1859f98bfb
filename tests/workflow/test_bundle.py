"""A bundle beside the real Snakemake: the command that it prints computes nothing where it is."""

import shlex
import shutil
import subprocess
import zipfile

import pytest

from tests.workflow.workspace import REPOSITORY, Workspace, copy_repository, with_dummies

pytestmark = pytest.mark.workflow


def test_the_unpacked_project_has_the_plan_of_the_results(tmp_path):
    workspace = with_dummies(copy_repository(tmp_path / "project"))
    shutil.copy(REPOSITORY / "CITATION.cff", workspace.folder)
    (workspace.folder / ".gitignore").write_text("/artefacts\n/reports\n.snakemake\n__pycache__\n")
    workspace.computed(hydra="train.walking.iterations=5")
    for command in (["init", "-q"], ["add", "-A"]):
        subprocess.run(["git", "-C", workspace.folder, *command], check=True)
    done = workspace.slider("bundle", "table1")
    assert (done.returncode, done.stderr) == (0, "")
    printed = done.stdout.splitlines()[-1].removeprefix("unpacked, this has the results: ")
    with zipfile.ZipFile(workspace.folder / "reports" / "table1.crate.zip") as archive:
        archive.extractall(tmp_path / "unpacked")
    unpacked = Workspace(tmp_path / "unpacked")
    before = unpacked.stages()
    words = shlex.split(printed)
    assert words[0] == "snakemake"
    again = unpacked.command(["-m", *words])
    assert again.returncode == 0, again.stderr
    assert unpacked.table.read_text() == workspace.table.read_text()
    assert unpacked.stages() == before
