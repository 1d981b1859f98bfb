"""The machine that a job runs on, as a person would name it."""

import os
import platform
from functools import cache
from pathlib import Path

_CPUINFO = Path("/proc/cpuinfo")


@cache
def machine() -> str:
    """Processor, number of its cores that this process may use, operating system."""
    return f"{processor()}, {_cores()} cores, {platform.system()}"


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
