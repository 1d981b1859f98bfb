"""The functions of a formulation as machine code, made once and shared by the jobs of all gaits.

CasADi writes them as C. A compiler that neither contracts nor reorders operations keeps every bit
of what CasADi's interpreter gives, in a fifth of the time. That is checked before the first use;
without a compiler, or with one that changes a bit, the interpreter evaluates.
"""

import fcntl
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path

import casadi as ca
import numpy as np

from slider.core import files
from slider.core.job import Job
from slider.gait.formulation import Formulation
from slider.gait.problem import Functions

WORTH = 50
"""Gaits that pay for a compilation twice: it takes 15 s and saves each 0.6 s."""

_FLAGS = ("-Og", "-ffp-contract=off", "-fPIC", "-shared")  # -O2 compiles ten times as long
_PATIENCE = 300.0  # of a compilation [s]
_POINTS = 3  # at which each function is compared


class Compiled:
    """Compiled functions in a job's cache; compiles them if many gaits wait, one job at a time."""

    def __init__(self, job: Job) -> None:
        self._job = job

    def __call__(self, form: Formulation, derive: Callable[[], Functions]) -> Functions:
        """Functions of a formulation; ``derive`` makes those that CasADi interprets."""
        if self._job.cache is None:
            return derive()
        path = self._job.cache / f"{_key(form)}.so"
        if (known := _known(path)) is not None:
            return _load(path, known) or derive()
        made = derive()
        if self._job.waiting < WORTH:
            return made
        with _alone(path) as alone:
            return (self._compile(path, made) if alone else {}) or made

    def _compile(self, path: Path, functions: Functions) -> Functions:
        """Compile, compare and keep functions; none, and a note of that, where it fails."""
        start = time.perf_counter()
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            built = _build(functions, Path(folder))
            names = list(functions) if built and _agree(functions, built) else []
            if built and names:
                built.replace(path)
        digest = files.digest_file(path) if names else ""
        files.write_json(_note(path), {"sha256": digest, "functions": names})
        outcome = f"compiled in {time.perf_counter() - start:.0f} s" if names else "interpreted"
        self._job.progress(f"functions of the gaits: {outcome}")
        return _load(path, names)


def _key(form: Formulation) -> str:
    """Digest of all that functions depend on but the source; the hip's least rate is a bound."""
    facts = [asdict(form.robot), asdict(form.config), form.turning, form.by_hip]
    return files.digest_value([*facts, sys.platform, platform.machine()])


def _note(path: Path) -> Path:
    return path.with_suffix(".json")


def _known(path: Path) -> list[str] | None:
    """Names of the functions of a whole library, none if there can be none; None: unknown."""
    with suppress(OSError, ValueError, KeyError, TypeError):
        note = files.read_json(_note(path))
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
def _alone(path: Path) -> Iterator[bool]:
    """Whether no other job compiles this library, nor has meanwhile."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.with_suffix(".lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            yield False
        else:
            yield _known(path) is None


def _build(functions: Functions, folder: Path) -> Path | None:
    """Library of functions; None without a compiler or where it fails."""
    compiler = shutil.which(os.environ.get("CC", "cc"))
    if compiler is None:
        return None
    generator = ca.CodeGenerator("functions.c")
    for function in functions.values():
        generator.add(function)
    generator.generate(f"{folder}{os.sep}")
    source, library = folder / "functions.c", folder / "functions.so"
    command = [compiler, *_FLAGS, str(source), "-o", str(library), "-lm"]
    try:
        subprocess.run(command, check=True, timeout=_PATIENCE)
    except (OSError, subprocess.SubprocessError):
        return None
    return library


def _agree(functions: Functions, library: Path) -> bool:
    """Tell whether each function gives the same bits in both ways, at random points."""
    rng, compiled = np.random.default_rng(0), _load(library, list(functions))
    return bool(compiled) and all(
        _same_bits(one.call(point), compiled[name].call(point))
        for name, one in functions.items()
        for point in (_point(one, rng) for _ in range(_POINTS))
    )


def _point(function: ca.Function, rng: np.random.Generator) -> list[np.ndarray]:
    """Arguments of the size of angles [rad] and of times [s]."""
    return [rng.uniform(0.1, 1.0, function.size_in(i)) for i in range(function.n_in())]


def _same_bits(ones: list[ca.DM], others: list[ca.DM]) -> bool:
    pairs = zip(ones, others, strict=True)
    return all(a.full().tobytes() == b.full().tobytes() for a, b in pairs)
