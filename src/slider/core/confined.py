"""Read a stranger's file in a process of its own, within limits of time and memory.

Whatever the file does to a parser, in Python or in C, ends with that process, whose answer is JSON.
"""

import importlib
import json
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

from slider.core.environment import job_environment
from slider.core.errors import UserError, require

_CPU, _WALL = 5, 60  # [s]
_MEMORY, _ANSWER = 2 << 30, 1 << 16  # [bytes]
_EXPECTED = f"what is read in {_CPU} s, {_MEMORY >> 30} GiB and {_ANSWER >> 10} KiB of values"
_ENDS: dict[int, str] = dict.fromkeys((signal.SIGXCPU, signal.SIGALRM), "more time")
_START = "import sys; sys.path.insert(0, sys.argv[1]); from slider.core import confined; "
_START += "confined.answer(*sys.argv[2:])"
_SOURCE = Path(__file__).parents[2]


def confined(function: str, path: Path, *others: Path) -> Any:
    """Plain value that ``module:function`` gives for a path, or several.

    Raises:
        UserError: the function raised it, or reached a limit.
    """
    command = [sys.executable, "-I", "-X", "utf8", "-c", _START, str(_SOURCE), function]
    command += map(str, (path, *others))
    variables = job_environment(os.environ, Path(os.devnull)) | {"OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, env=variables)
    if done.returncode < 0:
        end = signal.Signals(-done.returncode)
        found = _ENDS.get(end, f"what ends its parser: {signal.strsignal(end)}")
        raise UserError(f"{path}: expected {_EXPECTED}, found {found}")
    if done.returncode > 0:
        raise RuntimeError(done.stderr.decode(errors="replace"))
    found = json.loads(done.stdout)
    if "refused" in found:
        raise UserError(found["refused"])
    return found["value"]


def answer(function: str, *paths: str) -> None:
    """Print what a function gives, or the line with which it refuses the file."""
    _limit(resource.RLIMIT_CORE, 0)
    _limit(resource.RLIMIT_CPU, _CPU)
    if sys.platform == "linux":  # macOS refuses it
        _limit(resource.RLIMIT_AS, _MEMORY)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.alarm(_WALL)
    stdout = os.dup(1)
    os.dup2(2, 1)  # what a library prints is no answer
    (module, _, name), (path, *_) = function.partition(":"), paths
    read = getattr(importlib.import_module(module), name)
    try:
        text = json.dumps({"value": read(*map(Path, paths))})
        require(len(text) <= _ANSWER, path, _EXPECTED, "more values")
    except UserError as error:
        text = json.dumps({"refused": str(error)})
    except (MemoryError, RecursionError) as error:
        found = "more memory" if isinstance(error, MemoryError) else "thousands of brackets"
        text = json.dumps({"refused": f"{path}: expected {_EXPECTED}, found {found}"})
    with open(stdout, "w", encoding="utf-8") as file:
        file.write(text)


def _limit(kind: int, value: int) -> None:
    most = resource.getrlimit(kind)[1]
    resource.setrlimit(kind, (value if most == resource.RLIM_INFINITY else min(value, most), most))
