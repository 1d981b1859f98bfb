"""Errors of full and read-only disks become a line, others do not."""

import errno
import os
import resource
from pathlib import Path

import pytest

from slider.core.errors import file_line, is_of_disks
from slider.core.files import write_atomic


def test_a_file_that_does_not_fit_is_named_and_leaves_nothing(tmp_path):
    path, before = tmp_path / "plan.json", resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
    try:
        with pytest.raises(OSError, match="File too large") as caught:
            write_atomic(path, "x" * 1000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert is_of_disks(caught.value)
    assert file_line(caught.value, Path("artefacts")) == f"{path}: File too large"
    assert not list(tmp_path.iterdir())


def test_a_place_is_named_where_the_error_names_none():
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert is_of_disks(full)
    assert file_line(full, Path("artefacts")) == "artefacts: No space left on device"


@pytest.mark.parametrize("error", [ValueError("3"), OSError(errno.ENOENT, "none"), OSError("odd")])
def test_other_errors_are_left_alone(error):
    assert not is_of_disks(error)
