"""CasADi's functions as machine code, made once and shared by the jobs of a stage.

CasADi writes them as C. A compiler that neither contracts nor reorders operations keeps every bit
of CasADi's interpreter, in a fifth to a fifteenth of the time. That is checked at random points
before the first use; without a compiler, or with one that changes a bit, the interpreter evaluates.
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
"""By name."""
Source = Callable[[Any, Callable[[], Functions]], Functions]
"""Gives functions that depend on parameters alone, plain values; the second argument makes them."""

_FLAGS = ("-Og", "-ffp-contract=off", "-fPIC", "-shared")  # -O2 compiles ten times as long
_PATIENCE = 300.0  # of a compilation [s]
_RETRY_AFTER = 3600.0  # a failed compilation [s]
_SIZES = (1.0, 1.0, 1.0, 100.0)  # of the arguments, at points where each function is compared


def interpreted(parameters: Any, derive: Callable[[], Functions]) -> Functions:
    """Functions as CasADi evaluates them; ``Compiled`` has faster ones."""
    return derive()


class Compiled:
    """Compiled functions in a job's cache; compiles them where that pays, one job at a time.

    Args:
        job: its ``cache`` holds the libraries.
        subject: of the functions, for the line of progress.
        min_pending_jobs: that must wait for a compilation to pay. While one compiles the others
            interpret; where it pays for one job alone, the others wait.
    """

    def __init__(self, job: Job, subject: str, min_pending_jobs: int = 1) -> None:
        self._job, self._subject, self._min_pending_jobs = job, subject, min_pending_jobs

    def __call__(self, parameters: Any, derive: Callable[[], Functions]) -> Functions:
        """Functions that depend on ``parameters`` and the job's source alone."""
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
        """Compile, compare and keep functions; names of those kept."""
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
    """Names of the functions in a library; none soon after a failure, None where to compile."""
    if not note.is_file():
        return None
    names: list[str] = files.read_json(note)
    failed = not names and time.time() - note.stat().st_mtime < _RETRY_AFTER
    return names if failed or (names and path.is_file()) else None


def _load(path: Path, names: list[str]) -> Functions:
    """Functions of a library; none if it does not load on this machine."""
    try:
        return {name: ca.external(name, str(path.resolve())) for name in names}
    except RuntimeError:
        return {}


def _compiler() -> list[str]:
    """Command of the C compiler; none where there is none."""
    with suppress(ValueError):  # a quote that nothing closes
        words = shlex.split(os.environ.get("CC", "cc"))
        return words if words and shutil.which(words[0]) else []
    return []


def _build(functions: Functions, folder: Path, compiler: Sequence[str]) -> Path | None:
    """Library of functions; None where the compiler fails."""
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
    """Tell whether each function gives the same bits in both ways, at points of both signs.

    One NaN is as good as another.
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
