"""A job starts from a known environment: what no recipe holds changes no byte of a result."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from slider.artefacts.plan import Plan, read_plan
from slider.core.environment import job_environment, library_path
from tests.workflow.workspace import QUIET, Workspace, copy_repository, with_dummies

pytestmark = pytest.mark.workflow

PROBE = '''
import locale
import sys
import matplotlib
import numba
import numpy as np
import zarr


def documented():
    """Meaning."""


def run(section, inputs, out, job):
    import matplotlib.pyplot as plt

    matplotlib.rcParams["svg.hashsalt"] = "x"
    figure, axes = plt.subplots()
    axes.plot([0.2, 0.4])
    figure.savefig(out / "figure.svg", metadata={"Date": None})
    zarr.save_array(out / "array.zarr", np.arange(6.0).reshape(2, 3), zarr_format=3)
    base = np.random.default_rng(1).uniform(0.1, 1.0, (80, 80))
    np.save(out / "product.npy", base @ base + np.linalg.inv(base))
    facts = [numba.config.DISABLE_JIT, documented.__doc__, sys.flags.optimize]
    facts += [locale.getpreferredencoding(), sys.flags.no_user_site]
    (out / "ä.txt").write_text(f"ä {facts}")
    return {}
'''
VARIABLES = {
    "NUMBA_DISABLE_JIT": "1",
    "NUMBA_FASTMATH": "1",
    "ZARR_JSON_INDENT": "7",
    "ZARR_ARRAY__ORDER": "F",
    "PYTHONOPTIMIZE": "2",
    "MPLBACKEND": "module://nothing",
    "MUJOCO_GL": "osmesa",
    "OPENBLAS_CORETYPE": "Prescott",
    "ATEN_CPU_CAPABILITY": "default",
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
    "GIT_DIR": "/nowhere",
    "LC_ALL": "en_US.ISO-8859-1",
}
FILES = {
    ".numba_config.yaml": "disable_jit: 1\n",
    "matplotlibrc": "lines.color: red\naxes.facecolor: red\n",
    "ipopt.opt": "max_iter 1\n",
    "numpy.py": "raise ImportError('not this one')\n",
    ".config/matplotlib/matplotlibrc": "axes.facecolor: red\n",
    ".config/zarr/zarr.yaml": "json_indent: 7\n",
}


@pytest.fixture(scope="module")
def probe(tmp_path_factory) -> tuple[Workspace, Plan, Path]:
    """A pipeline whose gaits write what libraries make of their settings, and its plan."""
    workspace = with_dummies(copy_repository(tmp_path_factory.mktemp("probe") / "it's"))
    (workspace.folder / "src" / "slider" / "gait" / "stage.py").write_text(PROBE)
    done = workspace.snakemake("-n", "gait_library", hydra=QUIET)
    assert done.returncode == 0, done.stderr
    (path,) = (workspace.artefacts / "plans").glob("*.json")
    return workspace, read_plan(path), path


def result(probe: tuple[Workspace, Plan, Path], **variables: str) -> str:
    """Object of a gait, computed as Snakemake does it."""
    workspace, plan, path = probe
    job = next(job for job in plan.jobs.values() if job.stage == "gait")
    shutil.rmtree(workspace.artefacts / "index", ignore_errors=True)
    script = workspace.folder / "src" / "slider" / "core" / "environment.py"
    python = [sys.executable, "-I", "-X", "utf8", str(script)]
    done = subprocess.run(
        [*python, "run", "--plan", str(path.relative_to(workspace.folder)), job.recipe],
        cwd=workspace.folder,
        env=os.environ | variables,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    (manifest,) = workspace.manifests("gait")
    return manifest["object"]


@pytest.fixture(scope="module")
def expected(probe) -> str:
    return result(probe)


@pytest.mark.parametrize("kind", ["variables", "files", "path"])
def test_a_hostile_environment_changes_no_byte(probe, expected, kind, tmp_path):
    workspace = probe[0]
    for name, text in FILES.items():
        path = workspace.folder / name
        path.unlink(missing_ok=True)
        if kind == "files":
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
    (tmp_path / "slider.py").write_text("raise ImportError('not this one')\n")
    variables = {
        "variables": VARIABLES,
        "files": {"HOME": str(workspace.folder)},
        "path": {"PYTHONPATH": str(tmp_path), "PYTHONHOME": str(tmp_path), "HOME": "/proc/nobody"},
    }
    assert result(probe, **variables[kind]) == expected


def test_no_folder_with_libraries_of_others_comes_first(tmp_path):
    (tmp_path / "libcasadi.so.3.7").touch()
    assert library_path(f"/a::{tmp_path}:/b") == "/a:/b"


def test_variables_are_taken_by_an_allow_list(tmp_path):
    given = {"PATH": "p", "LC_TIME": "C", "SLURM_JOB_ID": "3", "CUDA_VISIBLE_DEVICES": "0"}
    found = job_environment(given | VARIABLES | {"HOME": "h"}, tmp_path)
    assert given.items() <= found.items()
    others = {"HOME", "USER", "MATPLOTLIBRC", "LC_ALL"}
    assert found.keys() == given.keys() | others
    assert found["HOME"] == str(tmp_path)
