"""Parts of other packages that these do not promise: what moved, with a new version, has a name."""

import inspect
from typing import Any

import pytest
from mlflow.tracking._tracking_service import utils
from snakemake.api import Workflow  # first: its modules import each other
from snakemake.jobs import Reason
from snakemake.workflow import DAG, JobScheduler

from slider.tracking import ARTIFACT_ROOT

SNAKEMAKE: dict[str, tuple[Any, str]] = {
    "jobs to run": (DAG, "def needrun_jobs(self"),
    "why a job runs": (DAG, "def reason(self, job)"),
    "forced by the command line": (Reason, "self.forced = "),
    "number of a job": (DAG, "def jobid(self, job)"),
    "the workflow's scheduler": (Workflow, "self.scheduler"),
    "limit of submissions": (JobScheduler, "if self.job_rate_limiter is None:"),
}


@pytest.mark.parametrize("what", SNAKEMAKE)
def test_snakemake_still_has(what):
    """As ``pipeline/private.py`` uses it."""
    owner, text = SNAKEMAKE[what]
    assert text in inspect.getsource(owner), f"{owner.__qualname__} has no longer: {text.strip()}"


def test_mujocos_web_viewer_still_keeps_its_address():
    web_viewer = pytest.importorskip("mujoco.studio.web_viewer")
    text = inspect.getsource(web_viewer.WebViewer)
    assert "self._host, config.http_port" in text, "expected WebViewer to listen at self._host"


def test_mlflow_still_reads_the_place_of_its_files():
    text = inspect.getsource(utils)
    assert f'"{ARTIFACT_ROOT}"' in text, f"expected {ARTIFACT_ROOT} in {utils.__name__}"
