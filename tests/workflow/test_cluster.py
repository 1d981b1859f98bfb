"""The Slurm profile on a cluster of one node: a local run's results, and nothing left behind."""

import importlib.util
import json
import signal
import sys
from collections.abc import Iterator
from shlex import quote

import pytest

from tests.workflow.slurm import CORES, Cluster, missing, one_node
from tests.workflow.workspace import (
    QUIET,
    TABLE,
    Workspace,
    copy_repository,
    with_dummies,
)

PLUGIN = "snakemake_executor_plugin_slurm"
pytestmark = [
    pytest.mark.workflow,
    pytest.mark.skipif(bool(missing()), reason=f"no {', '.join(missing())}: apt install slurm-wlm"),
    pytest.mark.skipif(quote(sys.executable) != sys.executable, reason="such a path is not quoted"),
    pytest.mark.skipif(importlib.util.find_spec(PLUGIN) is None, reason=f"no {PLUGIN}"),
]
HOSTILE = 'a "gäit" $(touch pwned)'  # without the quote at which Snakemake fails on a cluster
PROFILE = ("--workflow-profile", "profiles/slurm")
# For a disk and a queue that nobody shares.
SOON = (
    *("--latency-wait=5", "--seconds-between-status-checks=1", "--max-status-checks-per-second=9"),
    "--slurm-init-seconds-before-status-checks=1",
)


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    with one_node() as running:
        yield running


def submit(workspace: Workspace, cluster: Cluster, target: str = TABLE):
    """Start Snakemake with the profile."""
    arguments = (target, *PROFILE, *SOON)
    return workspace.start(*arguments, hydra=QUIET, **cluster.environment)


def forget(workspace: Workspace, *stages: str) -> None:
    """Remove the results of stages: manifests and, so that none is found again, the index."""
    for stage in stages:
        for path in (workspace.artefacts / stage).glob("*.json"):
            path.unlink()
    for path in (workspace.artefacts / "index").glob("*/*.json"):
        path.unlink()


def test_a_run_that_is_interrupted_twice_ends_with_the_table_of_a_local_run(
    cluster, real, tmp_path
):
    workspace = real.copy(tmp_path / HOSTILE)
    forget(workspace, "walking", "evaluation", "table1")
    workspace.table.unlink()
    head = submit(workspace, cluster)
    assert workspace.wait_for_job("evaluation")
    cluster.ask("scancel", *cluster.queue())
    _, text = head.communicate(timeout=120)
    assert head.returncode == 1
    assert "SLURM status is: 'CANCELLED'" in text
    assert "slider: the job's log is artefacts/logs/evaluation/" in text
    left_behind(workspace, cluster)

    head = submit(workspace, cluster)
    workspace.wait_for_job("evaluation")
    head.send_signal(signal.SIGTERM)
    head.communicate(timeout=60)
    assert head.returncode == 1
    left_behind(workspace, cluster)

    head = submit(workspace, cluster)
    _, text = head.communicate(timeout=240)
    assert head.returncode == 0, text
    assert workspace.table.read_bytes() == real.table.read_bytes()
    for stage in ("walking", "evaluation", "table1"):
        assert workspace.objects(stage) <= real.objects(stage)
    (facts,) = (workspace.artefacts / "walking").glob("*.run.json")
    assert json.loads(facts.read_text())["threads"] == CORES, "all cores of its own"
    assert not list(tmp_path.rglob("pwned"))


def left_behind(workspace: Workspace, cluster: Cluster) -> None:
    """Expect no job in the queue, no lock and no half result."""
    assert cluster.becomes_empty()
    assert not list(workspace.folder.glob(".snakemake/locks/*"))
    assert not list((workspace.artefacts / "objects" / "tmp").iterdir())


def test_a_submission_takes_several_gaits_and_says_which_failed(cluster, tmp_path):
    workspace = with_dummies(copy_repository(tmp_path))
    failing = "    1 / (section['velocity'][0] - 0.4)\n    (out"
    workspace.edit("src/slider/gait/stage.py", "    (out", failing)
    head = submit(workspace, cluster, "gait_library")
    _, text = head.communicate(timeout=120)
    assert head.returncode == 1
    assert text.count("has been submitted") == 1
    assert text.count("slider: the job's log is artefacts/logs/gait/") == 1
    assert "  ZeroDivisionError: float division by zero" in text
    assert len(list((workspace.artefacts / "logs" / "gait").iterdir())) == 2
    left_behind(workspace, cluster)
