"""The real Snakemake where processes are killed, or disks and clock are not as they should be.

``tests/faults`` breaks a job at every file operation.
"""

import json
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from slider.cli import main
from tests.workflow.workspace import AFTER_STANDING, QUIET, TABLE, WAIT, Workspace

pytestmark = pytest.mark.workflow

LONGER = f"{QUIET} train.walking.iterations=5"
LOOKS = [["store", "times"], ["library", "show"], ["play", "--headless", "--seconds", "0.1"]]


def ours(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.startswith("slider: ")]


def resumed(workspace: Workspace) -> list[bool]:
    """Whether jobs found the work folder of a killed one, as the dummy notes it."""
    facts = (workspace.artefacts / "walking").glob("*.run.json")
    return sorted(json.loads(path.read_text())["resumed"] for path in facts)


def test_a_killed_job_and_head_leave_nothing_and_are_resumed(workspace):
    before, table = workspace.manifests("walking"), workspace.table.read_bytes()
    (workspace.folder / WAIT).touch()
    head = workspace.start(TABLE, hydra=LONGER)
    job = workspace.wait_for_job("walking")
    head.kill()
    head.wait()
    os.kill(job, signal.SIGKILL)
    (workspace.folder / WAIT).unlink()
    assert workspace.snakemake("--unlock", hydra=LONGER).returncode == 0
    assert workspace.slider("store", "verify").returncode == 0
    assert workspace.manifests("walking") == before
    assert workspace.table.read_bytes() == table
    assert workspace.computed(LONGER) == AFTER_STANDING
    assert resumed(workspace) == [False, True]
    assert workspace.slider("store", "gc", "--keep", "1").returncode == 0
    assert resumed(workspace) == [True]
    assert not (workspace.artefacts / "objects" / "tmp").exists()


def test_a_pipeline_whose_job_a_signal_ends_fails_in_one_line_and_goes_on(workspace):
    """By the system where memory runs out, by Ctrl-C, by a closed terminal, by `kill`."""
    for number in ("SIGKILL", "SIGINT", "SIGHUP", "SIGTERM"):
        (workspace.folder / WAIT).touch()
        head = workspace.start(TABLE, hydra=LONGER)
        job = workspace.wait_for_job("walking")
        if number == "SIGKILL":
            os.kill(job, signal.SIGKILL)
        elif number == "SIGTERM":  # of the head alone
            head.terminate()
        else:
            os.killpg(head.pid, signal.Signals[number])
        if number == "SIGINT":  # once more while Snakemake tidies up
            time.sleep(0.05)
            with suppress(ProcessLookupError):
                os.killpg(head.pid, signal.SIGINT)
        _, said = head.communicate()
        assert head.returncode == 1, said
        ended = [line for line in ours(said) if f"slider: walking: ended by {number}" in line]
        # The others reach Snakemake as well: it may leave the line out.
        assert len(ended) == 1 or number != "SIGKILL"
        assert ours(said) == ended
        assert all(("memory" in line) is (number == "SIGKILL") for line in ended)
        assert "Command '" not in said
        assert [*workspace.folder.glob(".snakemake/locks/*")] == []
    (workspace.folder / WAIT).unlink()
    assert workspace.computed(LONGER) == AFTER_STANDING
    assert [*(workspace.artefacts / "objects" / "tmp").iterdir()] == []
    assert workspace.computed(LONGER, f"{TABLE} -R walking") == ["walking"]


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


def test_a_read_only_store_can_be_looked_at(real, tmp_path, monkeypatch):
    workspace = real.copy(tmp_path / "copy")
    with read_only(workspace.artefacts):
        dry = workspace.snakemake("-n", TABLE, hydra=LONGER)
        assert dry.returncode == 0, dry.stderr
        assert ours(dry.stderr) == []
        monkeypatch.chdir(workspace.folder)
        for command in LOOKS:
            assert main(command) == 0, command
        failed = workspace.snakemake(TABLE, hydra=LONGER)
    assert failed.returncode == 1
    (line,) = ours(failed.stderr)
    assert line.startswith("slider: expected to write artefacts/plans/")
    assert "Traceback" not in failed.stderr


def test_a_broken_database_stops_nothing(workspace):
    (workspace.artefacts / "mlflow.db").mkdir(parents=True)
    done = workspace.snakemake(TABLE, hydra="train.walking.iterations=5")
    assert done.returncode == 0, done.stderr
    assert "MLflow misses part of this run: unable to open database file" in done.stderr
