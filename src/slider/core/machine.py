"""The machine that a job runs on, as a person would name it."""

import os
import platform
from functools import cache
from pathlib import Path

_CPUINFO = Path("/proc/cpuinfo")
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
    """Processor, number of its cores that this process may use, operating system, kernels."""
    return f"{processor()}, {_cores()} cores, {platform.system()}, {kernels()}"


@cache
def kernels() -> str:
    """Architecture, instruction set and maker of the processor here: ``x86_64-avx512-intel``."""
    if platform.machine() != "x86_64":
        return platform.machine()
    flags = set(cpuinfo("flags").split())
    level = next(name for name, needs in _LEVELS.items() if flags.issuperset(needs))
    maker = cpuinfo("vendor_id")
    return "-".join(filter(None, ("x86_64", level, _MAKERS.get(maker, maker))))


def processor() -> str:
    """Its name; Linux says it in a file only, elsewhere Python knows."""
    return cpuinfo("model name") or platform.processor() or platform.machine()


def cpuinfo(field: str) -> str:
    """What Linux says about the first core, such as its ``flags``; else nothing."""
    if _CPUINFO.is_file():
        for line in _CPUINFO.read_text().splitlines():
            name, _, value = line.partition(":")
            if name.strip() == field:
                return value.strip()
    return ""


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
