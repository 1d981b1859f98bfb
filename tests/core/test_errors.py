"""Errors of full and read-only disks become a line, others do not."""

import errno
import os
import resource
from pathlib import Path

import pytest

from slider.core.errors import not_written
from slider.core.files import write_atomic

PLACE = Path("artefacts")


@pytest.fixture
def small_files():
    """Files of at most 100 bytes, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_file_that_does_not_fit_is_named_and_leaves_nothing(tmp_path, small_files):
    path = tmp_path / "plan.json"
    with pytest.raises(OSError, match="File too large") as caught:
        write_atomic(path, "x" * 1000)
    found = not_written(caught.value, PLACE)
    assert str(found) == f"expected to write {path}, found: File too large"
    assert not list(tmp_path.iterdir())


def caused_by(cause: Exception) -> RuntimeError:
    error = RuntimeError("a library's own words")
    error.__cause__ = cause
    return error


@pytest.mark.parametrize(
    "error",
    [
        OSError("1000 requested and 100 written"),  # as NumPy says it
        caused_by(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))),
    ],
)
def test_a_full_disk_counts_whoever_says_it(error):
    expected = "expected to write artefacts, found: No space left on device"
    assert str(not_written(error, PLACE)) == expected


@pytest.mark.parametrize("error", [ValueError("3"), OSError(errno.ENOENT, "none"), OSError("odd")])
def test_other_errors_are_left_alone(error):
    assert not_written(error, PLACE) is None


def denied(name: str) -> PermissionError:
    return PermissionError(errno.EACCES, "Permission denied", name)


@pytest.mark.parametrize("name", ["artefacts/logs/a.log", "reports/a.csv", ".snakemake/tmp"])
def test_a_missing_right_counts_where_the_pipeline_writes(name):
    line = f"expected to write {name}, found: Permission denied"
    assert str(not_written(denied(name), PLACE)) == line
    assert str(not_written(denied(str(Path(name).absolute())), PLACE)).endswith("denied")


@pytest.mark.parametrize("name", ["ffmpeg", ".venv/bin/ffmpeg", "/usr/bin/ffmpeg"])
def test_a_program_that_may_not_run_is_another_error(name):
    assert not_written(denied(name), PLACE) is None


@pytest.mark.parametrize("number", [errno.EACCES, errno.ENOSPC])
def test_a_mistake_after_an_error_keeps_its_trace(number):
    error = KeyError("a")
    error.__context__ = OSError(number, os.strerror(number), "artefacts/a")
    assert not_written(error, PLACE) is None
