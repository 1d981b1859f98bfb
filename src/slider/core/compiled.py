"""Functions over arrays as machine code, compiled by numba and kept in its cache.

There is no fast-math and no contraction, so that each operation rounds as IEEE 754 says, and the
target is the same for all x86-64 processors with AVX2: results are those of any of them.
Products of matrices are those of SciPy's BLAS (``slider.core.machine.kernels``). Settings of numba
from the environment or from ``.numba_config.yaml``, such as ``NUMBA_DISABLE_JIT``, do not apply.

The cache lies in ``NUMBA_CACHE_DIR``, or beside the source, where Python keeps its bytecode.
Numba does not compare constants that come from other modules, so each function has a folder named
after its source and constants. Jobs that start at once compile each for itself. Where nothing can
be written, every process compiles.
"""

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np

from slider.core.machine import cpuinfo

F = TypeVar("F", bound=Callable[..., Any])
_SETTINGS = cast(Any, numba).config  # without type stubs
_TARGET = "haswell", "+avx,+avx2,+bmi,+bmi2,+fma,+lzcnt,+movbe,+popcnt,+sse4.2"
_njit: Any = partial(numba.njit, error_model="numpy")


def compiled(function: F) -> F:
    """Compile a function for the types of its arguments when it is first called.

    It may use numbers, arrays and ``part``s of its own module only: these and the source of the
    module tell whether the machine code is up to date.
    """
    folder = _folder(function)
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK):  # numba would take another folder
        return cast(F, _njit(function))
    _SETTINGS.CACHE_DIR = str(folder)
    return cast(F, _njit(function, cache=True))


def _folder(function: Callable[..., Any]) -> Path:
    source = Path(function.__code__.co_filename)
    values = function.__globals__.items()
    constants = {n: v for n, v in values if isinstance(v, int | float | tuple | np.ndarray)}
    plain = {n: v.tolist() if isinstance(v, np.ndarray) else v for n, v in constants.items()}
    digest = hashlib.sha256(source.read_bytes() + repr(plain).encode()).hexdigest()
    parent = Path(os.environ.get("NUMBA_CACHE_DIR") or source.parent / "__pycache__")
    return parent / f"{source.stem}.{function.__qualname__}-{digest[:16]}"


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
