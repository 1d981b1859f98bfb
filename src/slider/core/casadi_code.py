"""CasADi functions as machine code, compiled once and shared by the jobs of a stage.

CasADi generates C code. A compiler that neither contracts nor reorders operations reproduces the
bits of CasADi's interpreter, 5 to 15 times as fast. This is checked at random points before the
first use; without a compiler, or if any bit differs, the interpreter is used.
"""

import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from filelock import FileLock, Timeout

from slider.core import files
from slider.core.job import Job

Functions = dict[str, ca.Function]
"""Functions by name."""
Source = Callable[[Any, Callable[[], Functions]], Functions]
"""Functions that depend only on parameters (plain values); the second argument derives them."""

_FLAGS = ("-Og", "-ffp-contract=off", "-fPIC", "-shared")  # -O2 takes ten times as long to compile
_PATIENCE = 300.0  # timeout of a compilation [s]
_RETRY_AFTER = 3600.0  # time until a failed compilation is retried [s]
_SIZES = (1.0, 1.0, 1.0, 100.0)  # bounds of the random arguments at which functions are compared


def interpreted(parameters: Any, derive: Callable[[], Functions]) -> Functions:
    """Functions evaluated by CasADi's interpreter; :class:`Compiled` is a faster ``Source``."""
    return derive()


class Compiled:
    """Compiled functions in a job's cache; one job compiles them if that saves time.

    Args:
        job: its ``cache`` holds the libraries.
        subject: name of the functions in the progress line.
        min_pending_jobs: number of pending jobs from which on compilation saves time. While one
            job compiles, others use the interpreter; if this number is 1, they wait.
    """

    def __init__(self, job: Job, subject: str, min_pending_jobs: int = 1) -> None:
        self._job, self._subject, self._min_pending_jobs = job, subject, min_pending_jobs

    def __call__(self, parameters: Any, derive: Callable[[], Functions]) -> Functions:
        """Functions that depend only on ``parameters`` and the job's source."""
        if self._job.cache is None:
            return derive()
        machine = sys.platform, platform.machine()
        path = self._job.cache / f"{files.digest_value([parameters, *machine])}.so"
        note = path.with_suffix(".json")
        if (names := _noted(path, note)) is not None:
            return _load(path, names) or derive()
        functions = derive()
        compiler = _compiler()
        if self._job.waiting < self._min_pending_jobs or not compiler:
            return functions
        path.parent.mkdir(parents=True, exist_ok=True)
        blocking = self._min_pending_jobs == 1
        with suppress(Timeout), FileLock(path.with_suffix(".lock"), blocking=blocking):
            if (names := _noted(path, note)) is None:
                names = self._compile(path, functions, compiler)
                files.write_json(note, names)
            return _load(path, names) or functions
        return functions

    def _compile(self, path: Path, functions: Functions, compiler: Sequence[str]) -> list[str]:
        """Compile functions and keep them if they agree; return their names, or none."""
        start, names = time.perf_counter(), list(functions)
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            library = _build(functions, Path(folder), compiler)
            loaded = _load(library, names) if library else {}
            if not library or not loaded:
                outcome, names = "interpreted, as they did not compile", []
            elif not _agree(functions, loaded):
                outcome, names = "interpreted, as the compiler changes bits", []
            else:
                library.replace(path)
                outcome = f"compiled in {time.perf_counter() - start:.1f} s"
        self._job.progress(f"functions of the {self._subject}: {outcome}")
        return names


def _noted(path: Path, note: Path) -> list[str] | None:
    """Names of the functions in a library; empty soon after a failure, None to compile."""
    if not note.is_file():
        return None
    names: list[str] = files.read_json(note)
    failed = not names and time.time() - note.stat().st_mtime < _RETRY_AFTER
    return names if failed or (names and path.is_file()) else None


def _load(path: Path, names: list[str]) -> Functions:
    """Functions of a library; empty if it does not load on this machine."""
    try:
        return {name: ca.external(name, str(path.resolve())) for name in names}
    except RuntimeError:
        return {}


def _compiler() -> list[str]:
    """Command of the C compiler; empty if there is none."""
    with suppress(ValueError):  # an unclosed quote
        words = shlex.split(os.environ.get("CC", "cc"))
        return words if words and shutil.which(words[0]) else []
    return []


def _build(functions: Functions, folder: Path, compiler: Sequence[str]) -> Path | None:
    """Path of the compiled library; None if the compiler fails."""
    generator = ca.CodeGenerator("functions.c")
    for function in functions.values():
        generator.add(function)
    generator.generate(f"{folder}{os.sep}")
    source, library = folder / "functions.c", folder / "functions.so"
    command = [*compiler, *_FLAGS, str(source), "-o", str(library), "-lm"]
    try:
        subprocess.run(command, check=True, timeout=_PATIENCE)
    except (OSError, subprocess.SubprocessError):
        return None
    return library


def _agree(functions: Functions, compiled: Functions) -> bool:
    """Whether interpreted and compiled functions return the same bits at random points.

    All NaN count as equal.
    """
    rng = np.random.default_rng(0)
    for name, function in functions.items():
        for size in _SIZES:
            shapes = map(function.size_in, range(function.n_in()))
            point = [rng.uniform(-size, size, shape) for shape in shapes]
            values = function.call(point), compiled[name].call(point)
            for a, b in ((one.full(), other.full()) for one, other in zip(*values, strict=True)):
                same = a.view(np.uint64) == b.view(np.uint64)
                if not np.all(same | (np.isnan(a) & np.isnan(b))):
                    return False
    return True
