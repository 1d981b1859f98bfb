"""The environment that a job starts from: what could change a result and is in no recipe is gone.

The pipeline runs this file as a script, ``python -I -X utf8 environment.py run …``: Python then
ignores ``PYTHON*``, packages of the user and the working directory. The package that this file
belongs to comes first on the path, whatever is installed. Variables are taken by an allow-list.
Options in the home folder do not apply, as jobs have one of their own; a job works in its work
folder (see the runner), so that none of the working directory do either.
"""

import os
import py_compile
import runpy
import sys
from collections.abc import Mapping
from contextlib import suppress
from importlib.util import cache_from_source
from pathlib import Path

ALLOWED = frozenset(
    {
        *("PATH", "LD_LIBRARY_PATH", "USER", "LOGNAME", "LANG", "TZ", "TMPDIR"),
        *("CC", "CUDA_DEVICE_ORDER", "CUDA_VISIBLE_DEVICES", "NVIDIA_VISIBLE_DEVICES"),
        *("NUMBA_CACHE_DIR", "WARP_CACHE_PATH"),
    }
)
"""Variables that a job takes over, beside those that begin with ``ALLOWED_PREFIXES``."""
ALLOWED_PREFIXES = ("LC_", "SLURM_")
LIBRARIES = ("libcasadi", "libipopt", "libmujoco", "libtorch*", "libc10", "libonnxruntime")
"""What the packages load with names that others use, too."""
_HOME = Path("artefacts") / "cache" / "home" / str(os.getuid())  # a store may have several users


def job_environment(variables: Mapping[str, str], home: Path) -> dict[str, str]:
    """Variables of a job: the allowed ones, and those that switch option files off."""
    allowed = {
        name: value
        for name, value in variables.items()
        if name in ALLOWED or name.startswith(ALLOWED_PREFIXES)
    }
    allowed.setdefault("USER", "nobody")  # torch asks for the name, which a container may lack
    return allowed | {"HOME": str(home), "MATPLOTLIBRC": os.devnull}


def library_path(folders: str) -> str:
    """``LD_LIBRARY_PATH`` without folders that hold other builds of the packages' libraries.

    They would come before those of the packages, as after sourcing a ROS.
    """
    kept = (
        folder
        for folder in folders.split(":")
        if not any(any(Path(folder).glob(f"{name}.so*")) for name in LIBRARIES)
    )
    return ":".join(filter(None, kept))


def check_bytecode(root: Path) -> None:
    """Let Python compare bytecode with the content of the modules below a folder, not their times.

    An archive may give a changed module the time and size of the one before: its bytecode would run
    under the recipe of the new source.
    """
    by_content = (3).to_bytes(4, "little")  # flags of PEP 552
    for path in root.rglob("*.py"):
        with suppress(OSError):  # there is none yet, or no right to write
            with open(cache_from_source(str(path)), "rb") as file:
                if file.read(8)[4:] == by_content:
                    continue
            mode = py_compile.PycInvalidationMode.CHECKED_HASH
            py_compile.compile(str(path), quiet=2, invalidation_mode=mode)


def main() -> None:
    """Run a command of ``slider`` in the environment of a job."""
    variables = job_environment(os.environ, _HOME.absolute())
    os.environ.clear()
    os.environ.update(variables)
    sys.path[:0] = [str(Path(__file__).resolve().parents[2])]
    runpy.run_module("slider.cli", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
