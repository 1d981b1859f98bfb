"""Compiled functions: the same bits, made once; without them all goes on."""

import fcntl
import os
import shutil
import stat
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import casadi as ca
import pytest

from slider.core.casadi_code import Compiled, Functions
from slider.core.job import Job

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
PARAMETERS = {"mass": 1.5, "names": ["a", "b"]}
MIN_PENDING_JOBS = 50


def small() -> Functions:
    x, y = ca.SX.sym("x", 3), ca.SX.sym("y")
    rows = ca.sin(x) * y + x / (y + 3)
    value, slope = ca.Function("f", [x, y], [rows]), ca.jacobian(rows, x)
    return {"f": value, "f_jacobian": ca.Function("f_jacobian", [x, y], [slope])}


def never() -> Functions:
    raise AssertionError("expected the compiled functions")


def compiled(folder: Path, waiting: int = MIN_PENDING_JOBS) -> Compiled:
    return Compiled(Job(folder, cache=folder / "cache", waiting=waiting), "tests", MIN_PENDING_JOBS)


def libraries(folder: Path) -> list[Path]:
    return sorted((folder / "cache").glob("*.so"))


def is_compiled(functions: Functions) -> bool:
    return all(str(function).endswith("External") for function in functions.values())


@pytest.fixture
def compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Puts a shell script in the place of the C compiler."""

    def put(lines: str) -> None:
        script = tmp_path / "compiler"
        script.write_text(f"#!/bin/sh\necho call >> {tmp_path}/calls\n{lines}\n")
        script.chmod(script.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("CC", str(script))

    return put


def test_the_first_job_compiles_and_the_others_load(tmp_path: Path):
    first = compiled(tmp_path)(PARAMETERS, small)
    later = compiled(tmp_path, waiting=1)(PARAMETERS, never)
    assert is_compiled(first)
    assert is_compiled(later)
    for name, function in small().items():
        given = [[0.3, -0.7, 2.0], 0.4]
        expected, found = function(*given).full(), later[name](*given).full()
        assert expected.tobytes() == found.tobytes()


CHANGED = "for last; do case $last in *.c) sed -i 's/{}/' $last;; esac; done; cc \"$@\""


@pytest.mark.parametrize(
    "lines",
    ["exit 1", CHANGED.format("sin(/cos("), CHANGED.format(r"sin(\([^)]*\))/sin(fabs(\1))")],
    ids=["fails", "changes bits everywhere", "changes bits of negative arguments"],
)
def test_a_compiler_that_fails_or_changes_bits_is_called_once(tmp_path: Path, compiler, lines: str):
    compiler(lines)
    for _ in range(2):
        assert not is_compiled(compiled(tmp_path)(PARAMETERS, small))
    assert (tmp_path / "calls").read_text() == "call\n"
    assert not libraries(tmp_path)


def test_a_lost_library_and_an_old_failure_are_compiled_again(tmp_path: Path):
    compiled(tmp_path)(PARAMETERS, small)
    (library,) = libraries(tmp_path)
    library.unlink()
    assert is_compiled(compiled(tmp_path)(PARAMETERS, small))
    library.with_suffix(".json").write_text("[]")
    assert not is_compiled(compiled(tmp_path)(PARAMETERS, small))
    os.utime(library.with_suffix(".json"), (0, 0))
    assert is_compiled(compiled(tmp_path)(PARAMETERS, small))


def test_other_parameters_have_other_functions(tmp_path: Path):
    compiled(tmp_path)(PARAMETERS, small)
    compiled(tmp_path)(PARAMETERS | {"mass": 2.0}, small)
    assert len(libraries(tmp_path)) == 2


def test_others_wait_where_a_compilation_pays_for_one_job_alone(tmp_path: Path):
    """Else they interpret."""
    compiled(tmp_path)(PARAMETERS, small)
    (library,) = libraries(tmp_path)
    library.with_suffix(".json").unlink()
    job = Job(tmp_path, cache=tmp_path / "cache")
    with library.with_suffix(".lock").open() as lock, ThreadPoolExecutor(1) as pool:
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert not is_compiled(compiled(tmp_path)(PARAMETERS, small))
        waiting = pool.submit(Compiled(job, "tests"), PARAMETERS, small)
        time.sleep(0.3)
        assert not waiting.done()
        fcntl.flock(lock, fcntl.LOCK_UN)
        assert is_compiled(waiting.result())
