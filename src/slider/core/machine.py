"""The machine that a job runs on: processor, numerical kernels, device, precision.

NumPy, BLAS and torch choose their kernels by the processor, so :func:`kernels` is part of the
recipes of the stages whose results depend on it.
"""

import importlib
import os
import platform
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from slider.core.errors import UserError

_CPUINFO = Path("/proc/cpuinfo")
_QUOTA = Path("/sys/fs/cgroup/cpu.max")
_LEVELS = {  # highest first, with flags of the processor
    "amx": ("amx_bf16", "amx_tile", "avx512_bf16"),
    "avx512_bf16": ("avx512_bf16",),
    "avx512": ("avx512f", "avx512bw", "avx512dq", "avx512vl"),
    "avx2": ("avx2", "fma"),
    "sse": (),
}
_MAKERS = {"GenuineIntel": "intel", "AuthenticAMD": "amd"}


@cache
def machine() -> str:
    """Processor, number of cores that this process may use, operating system, kernels."""
    return f"{processor()}, {cores()} cores, {platform.system()}, {kernels()}"


def cores() -> int:
    """Number of cores in this process's affinity mask, at most the quota of its container."""
    affinity = getattr(os, "sched_getaffinity", None)
    own = len(affinity(0)) if affinity else os.cpu_count() or 1
    with suppress(OSError, ValueError):  # no quota, or "max"
        quota, period = map(int, _QUOTA.read_text(encoding="utf-8").split())
        own = min(own, -(-quota // period))
    return own


@cache
def kernels() -> str:
    """Architecture, instruction set and vendor of the CPU, such as ``x86_64-avx512-intel``."""
    if platform.machine() != "x86_64":
        return platform.machine()
    flags = set(cpuinfo("flags").split())
    level = next(name for name, needs in _LEVELS.items() if flags.issuperset(needs))
    maker = cpuinfo("vendor_id")
    return "-".join(filter(None, ("x86_64", level, _MAKERS.get(maker, maker))))


def processor() -> str:
    """Name of the processor, from ``/proc/cpuinfo`` if available."""
    return cpuinfo("model name") or platform.processor() or platform.machine()


def cpuinfo(field: str) -> str:
    """Field of the first core in ``/proc/cpuinfo``, such as ``flags``; empty without one."""
    if _CPUINFO.is_file():
        for line in _CPUINFO.read_text(encoding="utf-8").splitlines():
            name, _, value = line.partition(":")
            if name.strip() == field:
                return value.strip()
    return ""


MOST_THREADS = 4
"""Maximum number of threads for the physics of a training."""


def training_threads(cores: int) -> int:
    """Half of the cores, from two to :data:`MOST_THREADS`.

    With more threads, most of the time of a training is that of the single-threaded networks.
    """
    return min(cores, max(2, min(cores // 2, MOST_THREADS)))


def device(setting: str) -> str:
    """``cpu`` or ``cuda``; ``auto`` is cuda if torch finds a device."""
    if setting != "auto":
        return setting
    return "cuda" if _has_cuda() else "cpu"


def precision(setting: str, device: str = "cpu") -> str:
    """``bfloat16`` or ``float32``; ``auto`` is bfloat16 on a CPU with instructions for it."""
    if setting != "auto":
        return setting
    fast = any(level in kernels() for level in ("amx", "avx512_bf16"))
    return "bfloat16" if fast and device == "cpu" else "float32"


def check_machine(section: Mapping[str, Any]) -> None:
    """Check that this machine has the ``numerics`` and the device of a section.

    Raises:
        UserError: it has not.
    """
    expected = section.get("numerics", kernels())
    if expected != kernels():
        raise UserError(
            f"numerics: expected {expected}, as where the pipeline was started, "
            f"found {kernels()} on {platform.node()} ({processor()})"
        )
    if section.get("train", {}).get("device") == "cuda" and not _has_cuda():
        raise UserError(f"device: expected cuda, found none on {platform.node()}")


def _has_cuda() -> bool:
    return importlib.import_module("torch").cuda.is_available()
