"""The real Snakemake where processes are killed, or disks and clock are not as they should be.

``tests/faults`` breaks a job at every file operation.
"""

import os
import shutil
import signal
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
    WAIT,
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


@pytest.fixture(scope="module")
def once(session_folder, tmp_path_factory) -> Workspace:
    return dummies_that_ran(session_folder, tmp_path_factory.mktemp("crash") / "once")


@pytest.fixture
def workspace(once, tmp_path) -> Workspace:
    return once.copy(tmp_path / "copy")


def ours(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.startswith("slider: ")]


def test_killed_jobs_and_heads_leave_nothing_and_are_resumed(workspace):
    """A job is killed, then job and head are; the result is marked as resumed."""
    before, table = workspace.manifests("walking"), workspace.table.read_bytes()
    (workspace.folder / WAIT).touch()
    head = workspace.start(TABLE, hydra=LONGER)
    os.kill(workspace.wait_for_job("walking"), signal.SIGKILL)
    assert head.wait() == 1
    head = workspace.start(TABLE, hydra=LONGER)
    job = workspace.wait_for_job("walking")
    head.kill()
    head.wait()
    os.kill(job, signal.SIGKILL)
    (workspace.folder / WAIT).unlink()
    locked = workspace.snakemake(TABLE, hydra=LONGER)
    assert locked.returncode == 1
    assert "--unlock" in locked.stderr
    assert workspace.snakemake("--unlock", hydra=LONGER).returncode == 0
    assert workspace.slider("store", "verify").returncode == 0
    assert workspace.manifests("walking") == before
    assert workspace.table.read_bytes() == table
    assert workspace.computed(LONGER) == AFTER_STANDING
    resumed = [manifest.get("resumed", False) for manifest in workspace.manifests("walking")]
    assert sorted(resumed) == [False, True]
    assert workspace.slider("store", "gc", "--keep", "1").returncode == 0
    assert [manifest.get("resumed") for manifest in workspace.manifests("walking")] == [True]
    assert not (workspace.artefacts / "tmp").exists()
    assert workspace.computed(LONGER) == []


def test_no_table_is_made_of_a_changed_digit(workspace, once):
    """Of a stage's first result, as a failing disk does it: size and times stay."""
    digest = sorted(workspace.objects("evaluation"))[0]
    path = next((workspace.artefacts / "objects" / digest[:2] / digest).iterdir())
    times, text = path.stat(), path.read_text()
    path.chmod(0o644)
    path.write_text(text.replace("0.", "7.", 1))
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    further = "evaluation.speeds=[0.2,0.4,0.3]"
    assert workspace.computed(further) == ["evaluation", "evaluation", "table1"]
    assert workspace.computed() == []
    assert workspace.table.read_bytes() == once.table.read_bytes()
    assert workspace.slider("store", "verify").returncode == 0


def limited(workspace: Workspace, size: int, hydra: str):
    """Run the pipeline where no file may have more than so many KiB, as on a full disk."""
    text = "import resource, runpy, sys; size = 1024 * int(sys.argv.pop(1));"
    text += "resource.setrlimit(resource.RLIMIT_FSIZE, (size, size));"
    text += "sys.argv[0] = 'snakemake'; runpy.run_module('snakemake', run_name='__main__')"
    config = ["--config", f"hydra=experiment=test {hydra}"]
    return workspace.command(["-c", text, str(size), "-j2", TABLE, *config])


@pytest.mark.parametrize(
    ("size", "place"),
    [(16, "artefacts/"), (1024, "walking: expected to write")],  # of the head, of a job
)
def test_a_full_disk_is_one_line_and_leaves_nothing(workspace, size, place):
    big = "    import torch; torch.save(torch.zeros(1_000_000), out / 'big.pt')\n    iterations ="
    workspace.edit("src/slider/training/stage.py", "    iterations =", big)
    table = workspace.table.read_bytes()
    failed = limited(workspace, size, LONGER)
    assert failed.returncode == 1
    (line,) = [line for line in ours(failed.stderr) if "expected to write" in line]
    assert place in line
    assert "Traceback" not in failed.stderr
    assert not list(workspace.artefacts.rglob(".*.part"))
    assert not list((workspace.artefacts / "tmp").iterdir())
    assert workspace.table.read_bytes() == table
    assert workspace.slider("store", "verify").returncode == 0
    assert {*AFTER_STANDING} <= {*workspace.computed(LONGER)}


def test_a_file_in_the_place_of_a_folder_is_one_line_and_repaired(workspace):
    shutil.rmtree(workspace.artefacts / "logs")
    (workspace.artefacts / "logs").write_text("")
    failed = workspace.snakemake(TABLE, hydra=LONGER)
    assert failed.returncode == 1
    (line,) = ours(failed.stderr)
    assert line.startswith("slider: expected a folder, found a file at artefacts/logs: ")
    assert "Traceback" not in failed.stderr
    assert "dropped logs, unreadable" in workspace.slider("store", "verify").stdout
    assert workspace.computed(LONGER) == AFTER_STANDING


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


def test_a_read_only_store_can_be_looked_at(session_folder, tmp_path):
    workspace = finished(session_folder).copy(tmp_path / "copy")
    with read_only(workspace.artefacts):
        dry = workspace.snakemake("-n", TABLE, hydra=LONGER)
        assert dry.returncode == 0, dry.stderr
        assert ours(dry.stderr) == []
        for command in LOOKS:
            shown = workspace.slider(*command)
            assert shown.returncode == 0, shown.stderr
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


def test_a_clock_that_was_set_back_and_a_broken_database_stop_nothing(workspace):
    tomorrow = time.time() + 86400
    for pattern in ("library/*.json", "current/*"):
        for path in workspace.artefacts.glob(pattern):
            os.utime(path, (tomorrow, tomorrow))
    (workspace.artefacts / "mlflow.db").mkdir(parents=True)
    done = workspace.snakemake(TABLE, hydra="train.walking.iterations=5")
    assert done.returncode == 0, done.stderr
    assert len([line for line in ours(done.stderr) if "they are from the future" in line]) == 1
    assert "MLflow misses part of this run: see artefacts/logs/tracking.log" in done.stderr
    assert workspace.computed(LONGER) == []
