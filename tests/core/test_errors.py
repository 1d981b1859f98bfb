"""Errors of full and read-only disks and of little memory become a line, others do not."""

import errno
import os
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import casadi
import numpy as np
import pytest
import torch

from slider.core.errors import no_memory, not_written
from slider.core.files import write_atomic

PLACE = Path("artefacts")
PLACES = ("artefacts/logs/a.log", "reports/a.csv", ".snakemake/tmp")


@contextmanager
def limited(kind: int, size: int) -> Iterator[None]:
    """A resource of which the system gives no more, also to pytest's own output."""
    before = resource.getrlimit(kind)
    resource.setrlimit(kind, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(kind, before)


def test_a_file_that_does_not_fit_is_named_and_leaves_nothing(tmp_path):
    path = tmp_path / "plan.json"
    full = limited(resource.RLIMIT_FSIZE, 100)
    with pytest.raises(OSError, match="File too large") as caught, full:
        write_atomic(path, "x" * 1000)
    found = not_written(caught.value, PLACE)
    assert str(found) == f"expected to write {path}, found: File too large"
    assert not list(tmp_path.iterdir())


def linked(error: Exception, link: str, other: Exception) -> Exception:
    setattr(error, link, other)
    return error


def denied(name: str) -> PermissionError:
    return PermissionError(errno.EACCES, "Permission denied", name)


FULL = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize(
    ("error", "found"),
    [
        (OSError("1000 requested and 100 written"), "artefacts, found: No space left on device"),
        (linked(RuntimeError("own words"), "__cause__", FULL), "artefacts, found: No space left"),
        *((denied(name), f"{name}, found: Permission denied") for name in PLACES),
        *((denied(str(Path(n).absolute())), f"{Path(n).absolute()}, found: P") for n in PLACES),
    ],
)
def test_a_full_disk_or_missing_right_counts_whoever_says_it(error, found):
    """The first one as NumPy says it."""
    assert str(not_written(error, PLACE)).startswith(f"expected to write {found}")


@pytest.mark.parametrize(
    "error",
    [
        *(ValueError("3"), OSError(errno.ENOENT, "none"), OSError("odd")),
        *map(denied, ("ffmpeg", ".venv/bin/ffmpeg", "/usr/bin/ffmpeg")),  # may not run
        linked(KeyError("a"), "__context__", denied("artefacts/a")),  # a mistake keeps its trace
    ],
)
def test_other_errors_are_left_alone(error):
    assert not_written(error, PLACE) is None
    assert no_memory(error) is None


@pytest.mark.skipif(sys.platform != "linux", reason="a limit that Linux obeys")
@pytest.mark.parametrize("allocate", [bytes, np.zeros, torch.zeros, casadi.DM.zeros])
def test_whoever_gets_no_memory_the_line_says_so_and_what_is_kept(allocate):
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    little = limited(resource.RLIMIT_AS, size + 2**26)
    with pytest.raises((MemoryError, RuntimeError)) as caught, little:
        allocate(10**9)
    line = str(no_memory(caught.value))
    assert line.startswith("expected more memory, found: ")
    assert "; results and checkpoints are kept, the same command again " in line
    assert "\n" not in line
