"""Functions over arrays as machine code, compiled by numba and kept in its cache.

There is no fast-math and no contraction, so that each operation rounds as IEEE 754 says, and the
target is the same for all x86-64 processors with AVX2: results are those of any of them.
Products of matrices are those of SciPy's BLAS (``slider.core.machine.kernels``). Settings of numba
from the environment or from ``.numba_config.yaml``, such as ``NUMBA_DISABLE_JIT``, do not apply.

The cache lies in ``NUMBA_CACHE_DIR``, or beside the source, where Python keeps its bytecode.
Numba checks neither the constants of other modules nor damage: each function has a folder named
after its source and constants, with the digests of its files. Jobs that start at once compile each
for itself. Where nothing can be written, every process compiles.
"""

import hashlib
import os
from collections.abc import Callable
from functools import cached_property, partial, update_wrapper
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np

from slider.core import files
from slider.core.machine import cpuinfo

F = TypeVar("F", bound=Callable[..., Any])
_SETTINGS = cast(Any, numba).config  # without type stubs
_TARGET = "haswell", "+avx,+avx2,+bmi,+bmi2,+fma,+lzcnt,+movbe,+popcnt,+sse4.2"
_njit: Any = partial(numba.njit, error_model="numpy")
_DIGESTS = "digests.json"


def compiled(function: F) -> F:
    """Compile a function for the types of its arguments when it is first called.

    It may use numbers, arrays and ``part``s of its own module only: these and the source of the
    module tell whether the machine code is up to date.
    """
    return cast(F, _Compiled(function))


def part(function: F) -> F:
    """Let compiled functions of the module call a function: it is compiled with each of them."""
    return cast(F, _njit(function))


def _fix_settings() -> None:
    """Through the environment, which numba reads again whenever it changes."""
    for name in [name for name in os.environ if name.startswith("NUMBA_")]:
        if name != "NUMBA_CACHE_DIR":
            del os.environ[name]
    os.environ["NUMBA_DISABLE_JIT"] = "0"
    if os.uname().machine == "x86_64" and "avx2" in cpuinfo("flags").split():
        os.environ.update(NUMBA_CPU_NAME=_TARGET[0], NUMBA_CPU_FEATURES=_TARGET[1])
    _SETTINGS.reload_config()


_fix_settings()  # before numba compiles anything


class _Compiled:
    """A function whose machine code is loaded or compiled when it is first called."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> Any:
        signatures = len(self.dispatcher.overloads)
        try:
            result = self.dispatcher(*arguments)
        except OSError:  # the machine code is there, but cannot be written
            return self.dispatcher(*arguments)
        if len(self.dispatcher.overloads) > signatures and self._folder.is_dir():
            _write_digests(self._folder)
        return result

    @cached_property
    def dispatcher(self) -> Any:
        """Numba's dispatcher, with a cache where one can be written."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            return _njit(self._function)
        if not os.access(self._folder, os.W_OK):  # numba would take another folder
            return _njit(self._function)
        _drop_damaged(self._folder)
        _SETTINGS.CACHE_DIR = str(self._folder)
        return _njit(self._function, cache=True)

    @cached_property
    def _folder(self) -> Path:
        source = Path(self._function.__code__.co_filename)
        values = self._function.__globals__.items()
        constants = {n: v for n, v in values if isinstance(v, int | float | tuple | np.ndarray)}
        plain = {n: v.tolist() if isinstance(v, np.ndarray) else v for n, v in constants.items()}
        digest = hashlib.sha256(source.read_bytes() + repr(plain).encode()).hexdigest()
        parent = Path(os.environ.get("NUMBA_CACHE_DIR") or source.parent / "__pycache__")
        return parent / f"{source.stem}.{self._function.__qualname__}-{digest[:16]}"


def _cache_files(folder: Path) -> list[Path]:
    """Numba's indices and machine code below a folder."""
    return sorted(folder.glob("*/*.nb[ic]"))


def _write_digests(folder: Path) -> None:
    paths = _cache_files(folder)
    files.write_json(folder / _DIGESTS, {path.name: files.digest_file(path) for path in paths})


def _drop_damaged(folder: Path) -> None:
    """Remove the files of a cache, if one of them is not as it was written."""
    try:
        digests = files.read_json(folder / _DIGESTS)
        intact = all(digests[p.name] == files.digest_file(p) for p in _cache_files(folder))
    except (OSError, ValueError, KeyError, TypeError):
        intact = False
    if not intact:
        for path in _cache_files(folder):
            path.unlink(missing_ok=True)
