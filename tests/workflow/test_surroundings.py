"""The real Snakemake where disks, clock or home folder are not as they should be."""

import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.workflow.workspace import (
    AFTER_STANDING,
    QUIET,
    TABLE,
    Workspace,
    dummies_that_ran,
    finished,
)

pytestmark = pytest.mark.workflow

LONGER = f"{QUIET} train.walking.iterations=5"
LOOKS = [
    ["store", "ls"],
    ["library", "show"],
    ["gait", "show", "--vx", "0.4"],
    ["play", "--headless", "--seconds", "0.1"],
]
WRITERS = {
    "text": "(out / 'big.txt').write_text('x' * 4_000_000)",
    "numpy": "import numpy; numpy.save(out / 'big.npy', numpy.zeros(500_000))",
    "torch": "import torch; torch.save(torch.zeros(1_000_000), out / 'big.pt')",
}


@pytest.fixture(scope="module")
def once(session_folder, tmp_path_factory) -> Workspace:
    return dummies_that_ran(session_folder, tmp_path_factory.mktemp("surroundings") / "once")


@pytest.fixture
def workspace(once, tmp_path) -> Workspace:
    return once.copy(tmp_path / "copy")


@contextmanager
def read_only(folder: Path) -> Iterator[None]:
    """Let nobody write below a folder: by modes, or by a mount for root, whom modes do not stop."""
    if os.geteuid() != 0:
        subprocess.run(["chmod", "-R", "a-w", folder], check=True)
        yield
        subprocess.run(["chmod", "-R", "u+w", folder], check=True)
        return
    if subprocess.run(["mount", "--bind", folder, folder], check=False).returncode != 0:
        pytest.skip("root that may not mount")
    try:
        subprocess.run(["mount", "-o", "remount,bind,ro", folder], check=True)
        yield
    finally:
        subprocess.run(["umount", "--lazy", folder], check=True)


def ours(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.startswith("slider: ")]


def test_a_read_only_store_can_be_looked_at(session_folder, tmp_path):
    workspace = finished(session_folder).copy(tmp_path / "copy")
    with read_only(workspace.artefacts):
        for hydra in (QUIET, LONGER):
            dry = workspace.snakemake("-n", TABLE, hydra=hydra)
            assert dry.returncode == 0, dry.stderr
            assert ours(dry.stderr) == []
        for command in LOOKS:
            found = workspace.slider(*command)
            assert found.returncode == 0, found.stderr
        failed = workspace.snakemake(TABLE, hydra=LONGER)
    assert failed.returncode == 1
    (line,) = ours(failed.stderr)
    assert line.startswith("slider: expected to write artefacts/current/started, found: ")
    assert "Traceback" not in failed.stderr


def test_a_read_only_project_is_one_line(workspace):
    with read_only(workspace.folder):
        failed = workspace.snakemake("-n", TABLE, hydra=QUIET)
        assert workspace.slider("store", "ls").returncode == 0
    assert failed.returncode == 1
    (line,) = ours(failed.stderr)
    assert "expected to write" in line
    assert "/.snakemake/" in line
    assert "Traceback" not in failed.stderr


@pytest.mark.parametrize("writer", WRITERS)
def test_a_job_on_a_full_disk_is_one_line_and_leaves_nothing(workspace, writer):
    """A limit on the size of files stands for the disk's."""
    path = "src/slider/training/stage.py"
    big = f"    if section['train']['iterations'] == 5:\n        {WRITERS[writer]}\n"
    workspace.edit(path, "    checkpoint =", f"{big}    checkpoint =")
    table = workspace.table.read_bytes()
    failed = limited(workspace, 1024, LONGER)
    assert failed.returncode == 1
    said = [line for line in ours(failed.stderr) if "expected to write" in line]
    assert len(said) == 1, failed.stderr
    assert said[0].startswith("slider: walking: expected to write artefacts")
    assert "Traceback" not in failed.stderr
    assert not list((workspace.artefacts / "tmp").iterdir())
    assert workspace.table.read_bytes() == table
    assert workspace.slider("store", "verify").returncode == 0
    assert workspace.computed(LONGER) == AFTER_STANDING


@pytest.mark.parametrize("size", [2, 16])  # Snakemake copies the Snakefile, of 1.1 KiB
def test_a_head_on_a_full_disk_is_one_line_and_leaves_nothing(workspace, size):
    failed = limited(workspace, size, LONGER)
    assert failed.returncode == 1
    (line,) = ours(failed.stderr)
    assert "expected to write artefacts/" in line
    assert "Traceback" not in failed.stderr
    assert not list(workspace.artefacts.rglob(".*.part"))
    assert workspace.computed(LONGER) == AFTER_STANDING


def limited(workspace: Workspace, size: int, hydra: str):
    """Run the pipeline where no file may have more than so many KiB."""
    text = "import resource, runpy, sys; size = 1024 * int(sys.argv.pop(1));"
    text += "resource.setrlimit(resource.RLIMIT_FSIZE, (size, size));"
    text += "sys.argv[0] = 'snakemake'; runpy.run_module('snakemake', run_name='__main__')"
    config = ["--config", f"hydra=experiment=test {hydra}"]
    return workspace.command(["-c", text, str(size), "-j2", TABLE, *config])


def test_results_from_the_future_are_used(workspace):
    """The clock was set back."""
    tomorrow = time.time() + 86400
    late = [workspace.artefacts.glob(pattern) for pattern in ("library/*.json", "current/*")]
    for path in (path for paths in late for path in paths):
        os.utime(path, (tomorrow, tomorrow))
    done = workspace.snakemake(TABLE, hydra=LONGER)
    assert done.returncode == 0, done.stderr
    assert len([line for line in ours(done.stderr) if "they are from the future" in line]) == 1
    assert workspace.computed(LONGER) == []


def test_a_home_folder_that_cannot_be_written_is_not_needed(workspace):
    done = workspace.snakemake(TABLE, hydra="train.walking.iterations=5", HOME="/proc/nobody")
    assert done.returncode == 0, done.stderr
    assert workspace.table.is_file()
