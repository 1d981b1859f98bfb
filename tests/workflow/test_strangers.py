"""What a stranger's machine has set, left and moved changes no byte of a result."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.workflow.workspace import TABLE, Workspace, copy_repository

pytestmark = pytest.mark.workflow

STAGES = ("gait", "library", "standing", "walking", "evaluation", "table1")
NAMELESS = ["unshare", "--user", "--map-user=54321", "--map-group=54321"]  # as docker run -u 54321
SHELL = ["sh", "-c", 'umask 077; ulimit -n 128; exec "$0" "$@" <&- 2>error.txt']
FILES = {
    ".numba_config.yaml": "disable_jit: 1\n",
    "matplotlibrc": "lines.color: red\naxes.facecolor: red\n",
    "ipopt.opt": "max_iter 1\n",
    **dict.fromkeys(("numpy.py", "random.py", "torch.py", "sitecustomize.py"), "1 / 0\n"),
    **dict.fromkeys(("yaml.py", "flask.py", "sqlalchemy.py"), "1 / 0\n"),  # of MLflow
    # Others' builds of what the packages load, as after sourcing a ROS.
    **dict.fromkeys(("libcasadi.so.3.7", "libc10.so", "libmujoco.so.4.0.0"), "no library\n"),
    ".config/matplotlib/matplotlibrc": "axes.facecolor: red\n",
    ".config/zarr/zarr.yaml": "json_indent: 7\n",
}
HOSTILE = {
    **{"PYTHONHASHSEED": "77", "PYTHONWARNINGS": "error", "PYTHONOPTIMIZE": "2"},
    **{"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"},
    **{"NUMBA_DISABLE_JIT": "1", "NUMBA_FASTMATH": "1", "ZARR_JSON_INDENT": "7"},
    **{"OMP_NUM_THREADS": "3", "OPENBLAS_CORETYPE": "Prescott", "ATEN_CPU_CAPABILITY": "default"},
    **{"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR", "TMPDIR": "/none"},
    **{"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA", "MALLOC_PERTURB_": "85"},
    **{"MLFLOW_TRACKING_URI": "http://127.0.0.1:1", "MPLBACKEND": "module://nothing"},
    **{"HYDRA_FULL_ERROR": "1", "MUJOCO_GL": "osmesa", "CC": "/none", "SHELL": "/bin/false"},
    **{"TZ": "Asia/Kathmandu", "COLUMNS": "0", "TERM": "dumb", "GIT_DIR": "/nowhere"},
    **{"HOME": "/proc/none", "XDG_CACHE_HOME": "/proc/none", "XDG_CONFIG_HOME": "/proc/none"},
    **{"MAKEFLAGS": "-j --jobserver-auth=3,4"},
}
"""Settings that libraries and tools read, each with a value that would change or end a run.

A job gets variables by an allow-list: see ``tests/core/test_environment.py``.
"""


@pytest.fixture
def latin1(tmp_path) -> dict[str, str]:
    """Variables of a locale with ISO-8859-1; of ASCII where none can be made."""
    name = "en_US.ISO-8859-1"
    command = ["localedef", "-i", "en_US", "-f", "ISO-8859-1", str(tmp_path / name)]
    if shutil.which("localedef") and not subprocess.run(command, capture_output=True).returncode:
        return {"LC_ALL": name, "LOCPATH": str(tmp_path)}
    return {"LC_ALL": "C"}


def nameless() -> list[str]:
    """Command that runs another as a user who is in no list of users, if there are namespaces."""
    fails = shutil.which(NAMELESS[0]) is None or subprocess.run([*NAMELESS, "true"]).returncode
    return [] if fails else NAMELESS


def foreign_sine(folder: Path) -> dict[str, str]:
    """Variable that puts another sine before the mathematical library's, if there is a compiler."""
    source, library = folder / "sine.c", folder / "sine.so"
    source.write_text("double sin(double x) { return x; }\n")
    command = ["cc", "-shared", "-fPIC", "-fno-builtin", str(source), "-o", str(library)]
    if shutil.which("cc") is None or subprocess.run(command).returncode:
        return {}
    return {"LD_PRELOAD": str(library)}


def test_a_stranger_computes_the_same_bytes(real, latin1, tmp_path):
    """In a copy elsewhere, without a name, with every setting and option file at once."""
    workspace = copy_repository(tmp_path / "elsewhere")
    for name, text in FILES.items():
        path = workspace.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    unnamed = ("USER", "LOGNAME", "LNAME", "USERNAME")
    kept = {name: value for name, value in os.environ.items() if name not in unnamed}
    paths = {"PYTHONPATH": str(workspace.folder), "LD_LIBRARY_PATH": f"/none:{workspace.folder}"}
    paths |= foreign_sine(tmp_path)
    snakemake = [sys.executable, "-I", "-m", "snakemake", "-j2", TABLE]  # as `make` does
    done = subprocess.run(
        [*nameless(), *SHELL, *snakemake, "--config", "hydra=experiment=test"],
        cwd=workspace.folder,
        env=kept | HOSTILE | paths | latin1,
    )
    error = (workspace.folder / "error.txt").read_text(encoding="utf-8", errors="replace")
    assert done.returncode == 0, error
    assert "Traceback" not in error
    assert "MLflow misses" not in error
    assert workspace.table.read_bytes() == real.table.read_bytes()
    for stage in STAGES:
        assert workspace.objects(stage) == real.objects(stage), stage


def test_a_moved_copy_computes_nothing_and_runs_its_own_source(real, tmp_path):
    """Also where ``PYTHONPATH``, as in a copied ``.venv``, names the original's source."""
    moved = Workspace(real.copy(tmp_path / "copy").folder.rename(tmp_path / "moved"))
    original = str(real.folder / "src")
    moved.table.unlink()
    assert moved.computed(PYTHONPATH=original) == []
    assert moved.table.read_bytes() == real.table.read_bytes()
    source = moved.folder / "src/slider/gait/stage.py"
    source.write_text(source.read_text(encoding="utf-8") + "\nunused = 1\n", encoding="utf-8")
    assert "Nothing to be done" not in moved.snakemake("-n", PYTHONPATH=original).stdout
