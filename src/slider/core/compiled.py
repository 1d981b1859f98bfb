"""Array functions compiled to machine code by numba and kept in its cache.

There is no fast-math and no contraction, so each operation rounds according to IEEE 754, and the
target is the same for all x86-64 processors with AVX2, so that they produce the same results.
Matrix products use SciPy's BLAS (``slider.core.machine.kernels``). Settings of numba from the
environment or from ``.numba_config.yaml``, such as ``NUMBA_DISABLE_JIT``, do not apply.

The cache lies in ``NUMBA_CACHE_DIR``, or beside the source, where Python keeps its bytecode.
Numba does not detect changes of constants from other modules, so each function has a folder named
after its source and constants. Jobs that start simultaneously compile separately. If the folder is
not writable, every process compiles.
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
    """Compile a function at its first call, for the types of its arguments.

    It may use only numbers, arrays and ``part``s of its own module: these and the source of the
    module determine whether the cached machine code is up to date.
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
    """Make a function callable from compiled functions of the module, and compile it with them."""
    return cast(F, _njit(function))


def _fix_settings() -> None:
    """Fix numba's settings through the environment, which it reads again whenever it changes."""
    for name in [name for name in os.environ if name.startswith("NUMBA_")]:
        if name != "NUMBA_CACHE_DIR":
            del os.environ[name]
    os.environ["NUMBA_DISABLE_JIT"] = "0"
    if os.uname().machine == "x86_64" and "avx2" in cpuinfo("flags").split():
        os.environ.update(NUMBA_CPU_NAME=_TARGET[0], NUMBA_CPU_FEATURES=_TARGET[1])
    _SETTINGS.reload_config()


_fix_settings()  # before numba compiles anything
