"""The environment of a job, without anything that could change results but is not in a recipe.

The pipeline runs this file as a script, ``python -I -X utf8 environment.py run …``: Python then
ignores ``PYTHON*``, packages of the user and the working directory. The package of this file comes
first on the path, whatever is installed. Environment variables are filtered by an allow-list. Jobs
have their own home and work folders, so that no option files from elsewhere apply.

Signals end a job immediately, without a handler: libraries that call Python, such as CasADi,
swallow exceptions of a handler and continue with wrong numbers. The store tolerates even SIGKILL.
"""

import os
import runpy
import signal
import sys
from collections.abc import Mapping
from pathlib import Path

ALLOWED = frozenset(
    {
        *("PATH", "LD_LIBRARY_PATH", "USER", "LOGNAME", "LANG", "TZ", "TMPDIR"),
        *("CC", "CUDA_DEVICE_ORDER", "CUDA_VISIBLE_DEVICES", "NVIDIA_VISIBLE_DEVICES"),
        *("NUMBA_CACHE_DIR", "WARP_CACHE_PATH"),
    }
)
"""Variables that a job inherits, beside those that begin with ``LC_``."""
LIBRARIES = ("libcasadi", "libipopt", "libmujoco", "libtorch*", "libc10", "libonnxruntime")
"""Libraries of the packages whose names other installations use as well."""
_HOME = Path("artefacts") / "cache" / "home" / str(os.getuid())  # a store may have several users


def job_environment(variables: Mapping[str, str], home: Path) -> dict[str, str]:
    """Variables of a job: the allowed ones, and those that disable option files."""
    names = [n for n in variables if n in ALLOWED or n.startswith("LC_")]
    allowed = {"USER": "nobody"}  # torch asks for the name, which a container may lack
    allowed |= {name: variables[name] for name in names}
    return allowed | {"HOME": str(home), "MATPLOTLIBRC": os.devnull}


def library_path(folders: str) -> str:
    """``LD_LIBRARY_PATH`` without folders that hold other builds of the packages' libraries.

    They would take precedence over those of the packages, for example after sourcing ROS.
    """

    def has_others(folder: str) -> bool:
        return any(any(Path(folder).glob(f"{name}.so*")) for name in LIBRARIES)

    return ":".join(f for f in folders.split(":") if f and not has_others(f))


def main() -> None:
    """Run a command of ``slider`` in the environment of a job."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # unless it is ignored
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # the only signal that Python handles
    variables = job_environment(os.environ, _HOME.absolute())
    os.environ.clear()
    os.environ.update(variables)
    sys.path[:0] = [str(Path(__file__).resolve().parents[2])]
    runpy.run_module("slider.cli", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
