"""Functions over arrays as machine code, compiled by numba once per source and kept.

There is no fast-math and no contraction, so that each operation rounds as IEEE 754 says, and the
target is one and the same for all x86-64 processors with AVX2: results are those of any of them.
Products of matrices are those of SciPy's BLAS (``slider.core.machine.kernels``).

What is compiled lies in ``NUMBA_CACHE_DIR``, or beside the source, where Python keeps its bytecode.
Jobs that start at once compile each for itself, and one of the results stays. A damaged file is
compiled anew; where nothing can be written, every process compiles.
"""

import hashlib
import os
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar, cast

import llvmlite
import numba
import numpy as np
import scipy
from numba.core import serialize
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult

from slider.core.machine import cpuinfo

F = TypeVar("F", bound=Callable[..., Any])
_SETTINGS = cast(Any, numba).config  # without type stubs
_TARGET = "haswell", "+avx,+avx2,+bmi,+bmi2,+fma,+lzcnt,+movbe,+popcnt,+sse4.2"


def compiled(function: F) -> F:
    """Compile a function for the types of its arguments when it is first called.

    It may use numbers, arrays and ``part``s of its own module only: these and the source of the
    module tell whether the machine code is up to date.
    """
    dispatcher = cast(Any, numba.njit(function, error_model="numpy"))
    dispatcher._cache = _Kept(function)
    return dispatcher


def part(function: F) -> F:
    """Let compiled functions of the module call a function: it is compiled with each of them."""
    return cast(F, numba.njit(function, error_model="numpy"))


def _fix_target() -> None:
    """Through the environment: numba reads its settings anew whenever that changes."""
    if os.uname().machine == "x86_64" and "avx2" in cpuinfo("flags").split():
        os.environ.update(NUMBA_CPU_NAME=_TARGET[0], NUMBA_CPU_FEATURES=_TARGET[1])
        _SETTINGS.reload_config()


_fix_target()  # before numba makes anything


class _Kept(_Cache):
    """Machine code of a function, a file for each signature: digest of what follows, pickle."""

    def __init__(self, function: Callable[..., Any]) -> None:
        source = Path(function.__code__.co_filename)
        self._source, self._name = source, f"{source.stem}.{function.__qualname__}"
        self._values = function.__globals__
        self._folder = Path(os.environ.get("NUMBA_CACHE_DIR") or source.parent / "__pycache__")

    @property
    def cache_path(self) -> str:
        """Folder."""
        return str(self._folder)

    def load_overload(self, sig: Any, target_context: Any) -> CompileResult | None:
        """What is kept for a signature; none where there is none, or it is damaged."""
        target_context.refresh()
        with suppress(OSError):
            digest, content = _split(self._path(sig).read_bytes())
            if digest == hashlib.sha256(content).digest():
                return CompileResult._rebuild(target_context, *pickle.loads(content))
        return None

    def save_overload(self, sig: Any, data: CompileResult) -> None:
        """Keep it, if that is possible."""
        content = serialize.dumps(data._reduce())
        path = self._path(sig)
        part = path.with_name(f".{path.name}.{os.getpid()}.part")  # files.TEMPORARY_PATTERN
        with suppress(OSError):
            path.parent.mkdir(parents=True, exist_ok=True)
            part.write_bytes(hashlib.sha256(content).digest() + content)
            part.replace(path)

    def _path(self, sig: Any) -> Path:
        kinds = int, float, tuple, np.ndarray
        constants = {n: v for n, v in self._values.items() if isinstance(v, kinds)}
        values = {n: v.tolist() if isinstance(v, np.ndarray) else v for n, v in constants.items()}
        versions = numba.__version__, llvmlite.__version__, scipy.__version__, sys.version
        target = _SETTINGS.CPU_NAME, _SETTINGS.CPU_FEATURES
        facts = repr((str(sig), values, *versions, *target)).encode()
        digest = hashlib.sha256(self._source.read_bytes() + facts).hexdigest()
        return self._folder / f"{self._name}-{digest[:16]}.machine"

    def enable(self) -> None:
        """Nothing: it always is."""

    def disable(self) -> None:
        """Nothing."""

    def flush(self) -> None:
        """Nothing: what is out of date has another name."""


def _split(content: bytes) -> tuple[bytes, bytes]:
    size = hashlib.sha256().digest_size
    return content[:size], content[size:]
