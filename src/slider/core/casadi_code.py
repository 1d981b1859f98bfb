"""CasADi's functions as machine code, made once and shared by the jobs of a stage.

CasADi writes them as C. A compiler that neither contracts nor reorders operations keeps every bit
of what CasADi's interpreter gives, in a fifth to a fifteenth of the time. That is checked at random
points before the first use; without a compiler, or with one that changes a bit, the interpreter
evaluates. Where a compilation fails, the next pipeline run tries again.
"""

import fcntl
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Protocol

import casadi as ca
import numpy as np

from slider.core import files
from slider.core.job import Job

Functions = dict[str, ca.Function]
"""By name."""

_FLAGS = ("-Og", "-ffp-contract=off", "-fPIC", "-shared")  # -O2 compiles ten times as long
_PATIENCE = 300.0  # of a compilation [s]
_SIZES = (1.0, 1.0, 1.0, 100.0)  # of the arguments, at points where each function is compared


class Source(Protocol):
    """Where functions come from."""

    def __call__(self, facts: Any, derive: Callable[[], Functions]) -> Functions:
        """Functions that depend on ``facts`` alone, plain values; ``derive`` makes them."""
        ...


def interpreted(facts: Any, derive: Callable[[], Functions]) -> Functions:
    """Functions as CasADi evaluates them; ``Compiled`` has faster ones."""
    return derive()


class Compiled:
    """Compiled functions in a job's cache; compiles them where that pays, one job at a time.

    ``worth`` jobs must wait for a compilation to pay, and while one compiles the others interpret.
    Where it pays for one job alone, the others wait. ``subject`` says what the functions are of.
    """

    def __init__(self, job: Job, subject: str, worth: int = 1) -> None:
        self._job, self._subject, self._worth = job, subject, worth
        self._run = job.volatile.get("pipeline_started", "")

    def __call__(self, facts: Any, derive: Callable[[], Functions]) -> Functions:
        """Functions that depend on ``facts`` and the job's source alone."""
        if self._job.cache is None:
            return derive()
        machine = sys.platform, platform.machine()
        path = self._job.cache / f"{files.digest_value([facts, *machine])}.so"
        if (known := _known(path, self._run)) is not None:
            return _load(path, known) or derive()
        made = derive()
        compiler = _compiler()
        if self._job.waiting < self._worth or not compiler:
            return made
        with _alone(path, wait=self._worth == 1) as alone:
            if not alone:
                return made
            if (known := _known(path, self._run)) is None:
                known = self._compile(path, made, compiler)
        return _load(path, known) or made

    def _compile(self, path: Path, functions: Functions, compiler: Sequence[str]) -> list[str]:
        """Compile, compare and keep functions; names of those kept, and a note of them."""
        start, names = time.perf_counter(), list(functions)
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            built = _build(functions, Path(folder), compiler)
            loaded = _load(built, names) if built else {}
            outcome = "interpreted, as they did not compile"
            if loaded and not _agree(functions, loaded):
                outcome = "interpreted, as the compiler changes bits"
                names = []
            elif built and loaded:
                built.replace(path)
                outcome = f"compiled in {time.perf_counter() - start:.1f} s"
        digest = files.digest_file(path) if loaded and names else ""
        note = {"sha256": digest, "functions": names, "failed_in": None if loaded else self._run}
        files.write_json(_note(path), note)
        self._job.progress(f"functions of the {self._subject}: {outcome}")
        return names if digest else []


def _note(path: Path) -> Path:
    return path.with_suffix(".json")


def _known(path: Path, run: str) -> list[str] | None:
    """Names of the functions of a whole library, none if there can be none in a pipeline run.

    None: unknown.
    """
    with suppress(OSError, ValueError, KeyError, TypeError):
        note = files.read_json(_note(path))
        if note["failed_in"] == run:
            return []
        if not note["functions"] or note["sha256"] == files.digest_file(path):
            return note["functions"]
    return None


def _load(path: Path, names: list[str]) -> Functions:
    """Functions of a library; none if it does not load on this machine."""
    try:
        return {name: ca.external(name, str(path.resolve())) for name in names}
    except RuntimeError:
        return {}


@contextmanager
def _alone(path: Path, wait: bool) -> Iterator[bool]:
    """Whether no other job compiles this library; ``wait`` until none does."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.with_suffix(".lock").open("w", encoding="utf-8") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except OSError:
            yield False
        else:
            yield True


def _compiler() -> list[str]:
    """Command of the C compiler; none where there is none."""
    with suppress(ValueError):  # a quote that nothing closes
        words = shlex.split(os.environ.get("CC", "cc"))
        if words and shutil.which(words[0]):
            return words
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
    """Tell whether each function gives the same bits in both ways, at random points."""
    rng = np.random.default_rng(0)
    return all(
        _same_bits(one.call(point), compiled[name].call(point))
        for name, one in functions.items()
        for point in (_point(one, size, rng) for size in _SIZES)
    )


def _point(function: ca.Function, size: float, rng: np.random.Generator) -> list[np.ndarray]:
    """Arguments of both signs."""
    return [rng.uniform(-size, size, function.size_in(i)) for i in range(function.n_in())]


def _same_bits(ones: list[ca.DM], others: list[ca.DM]) -> bool:
    """Tell whether all bits are the same; one NaN is as good as another."""
    pairs = ((a.full(), b.full()) for a, b in zip(ones, others, strict=True))
    return all(
        np.all((a.view(np.uint64) == b.view(np.uint64)) | (np.isnan(a) & np.isnan(b)))
        for a, b in pairs
    )
