"""Locks: one holder of a name, however the last one ended; and one who holds them all."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from slider.artefacts.store import Timeout, exclusive, nobody_else
from slider.core.errors import UserError

COUNT = """
import sys
from pathlib import Path
from slider.artefacts.store import exclusive

folder = Path(sys.argv[1])
for _ in range(20):
    with exclusive(folder / "locks", "x"):
        count = int((folder / "count").read_text())
        (folder / "count").write_text(str(count + 1))
"""
HOLD = """
import sys, time
from pathlib import Path
from slider.artefacts.store import exclusive

with exclusive(Path(sys.argv[1]), "x"):
    print("held", flush=True)
    time.sleep(60)
"""


def test_only_one_process_holds_a_name_and_no_file_stays(tmp_path: Path):
    """Read, add one, write: without the lock, counts get lost."""
    (tmp_path / "count").write_text("0")
    command = [sys.executable, "-c", COUNT, str(tmp_path)]
    processes = [subprocess.Popen(command) for _ in range(4)]
    assert [process.wait() for process in processes] == [0] * 4
    assert (tmp_path / "count").read_text() == "80"
    assert [path.name for path in (tmp_path / "locks").iterdir()] == ["all.lock"]


@pytest.fixture
def holder(tmp_path: Path):
    """A process that holds the name ``x``."""
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"held\n"
        yield process
        process.kill()


def test_a_killed_process_holds_nothing(tmp_path: Path, holder):
    with pytest.raises(UserError, match="expected no running job"), nobody_else(tmp_path):
        pass
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    with nobody_else(tmp_path):
        pass
    assert not (tmp_path / "x.lock").exists()
    with exclusive(tmp_path, "x"):
        pass


def test_other_names_are_free_and_all_of_them_are_not(tmp_path: Path, holder):
    with (
        exclusive(tmp_path, "y"),
        pytest.raises(
            UserError, match=f"^expected no running job in {tmp_path.parent}, found one$"
        ),
        nobody_else(tmp_path),
    ):
        pass
    assert holder.poll() is None


def test_what_need_not_wait_does_not(tmp_path: Path, holder):
    with pytest.raises(Timeout), exclusive(tmp_path, "x", timeout=0):
        pass
    with exclusive(tmp_path, "y", timeout=0):
        assert (tmp_path / "y.lock").exists()
    assert {path.stem for path in tmp_path.iterdir()} == {"all", "x"}


@pytest.mark.parametrize("name", ["locks", "locks/x.lock", "locks/all.lock"])
def test_something_else_in_the_place_of_a_lock_is_one_line(tmp_path: Path, name: str):
    if name == "locks":
        (tmp_path / name).write_text("")
    else:
        (tmp_path / name).mkdir(parents=True)
    for attempt in (exclusive(tmp_path / "locks", "x"), nobody_else(tmp_path / "locks")):
        with pytest.raises(UserError, match=r"expected a lock file at .*\.lock, found: "), attempt:
            pass


def test_a_file_system_without_locks_is_one_line(tmp_path: Path, monkeypatch):
    def acquire(self):
        raise NotImplementedError("FileSystem does not appear to support flock")

    monkeypatch.setattr("slider.artefacts.store.FileLock.acquire", acquire)
    message = r"found: a file system without locks$"
    with pytest.raises(UserError, match=message), exclusive(tmp_path, "a"):
        pass
