"""Errors of full and read-only disks and of little memory become a line, others do not."""

import errno
import os
import resource
import sys
from collections.abc import Callable, Iterator
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
def small_files() -> Iterator[None]:
    """Files of at most 100 bytes, as on a full disk; pytest's own output, too."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_file_that_does_not_fit_is_named_and_leaves_nothing(tmp_path):
    path = tmp_path / "plan.json"
    with pytest.raises(OSError, match="File too large") as caught, small_files():
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


def memory_error(allocate: Callable[[int], object]) -> Exception:
    """What a library raises where the system gives it no more memory."""
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (size + 2**26, before[1]))
    try:
        allocate(10**9)
    except Exception as error:
        return error
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
    raise AssertionError("there was enough memory")


@pytest.mark.skipif(sys.platform != "linux", reason="a limit that Linux obeys")
@pytest.mark.parametrize("allocate", [bytes, np.zeros, torch.zeros, casadi.DM.zeros])
def test_whoever_gets_no_memory_the_line_says_so_and_what_is_kept(allocate):
    line = str(no_memory(memory_error(allocate)))
    assert line.startswith("expected more memory, found: ")
    assert "; results and checkpoints are kept, the same command again " in line
    assert "\n" not in line
