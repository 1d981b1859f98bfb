"""Remotes beside the real Snakemake."""

import pytest

from tests.workflow.workspace import (
    EVERYTHING,
    QUIET,
    TABLE,
    Workspace,
    copy_repository,
    dummies_that_ran,
    with_dummies,
)

pytestmark = pytest.mark.workflow


@pytest.fixture(scope="module")
def giver(tmp_path_factory) -> Workspace:
    """A pipeline of dummies that ran and pushed all to a folder beside it."""
    workspace = dummies_that_ran().copy(tmp_path_factory.mktemp("giver") / "once")
    pushed = workspace.slider("store", "push", str(workspace.folder / "remote"))
    assert pushed.stdout.startswith(f"push to {workspace.folder}/remote: {len(EVERYTHING)} sent (")
    return workspace


def test_the_pipeline_takes_what_it_needs_and_computes_what_is_damaged(giver, tmp_path):
    remote = giver.folder / "remote"
    result = giver.manifests("gait")[0]["result"]
    (remote / "files" / result["files"]["gait.txt"]["sha256"]).write_bytes(b"")
    taker = with_dummies(copy_repository(tmp_path / "taker"))
    run = taker.snakemake(TABLE, hydra=f"{QUIET} store.remote={remote}")
    assert run.returncode == 0, run.stderr
    assert f"damaged in {remote}: expected object {result['object'][:12]}, found " in run.stderr
    waiting = len(EVERYTHING) - 2  # in the index, for the damaged gait
    start = f"slider: from {remote}: "
    (line,) = [line for line in run.stderr.splitlines() if line.startswith(start)]
    for count in (" 1 taken", " 1 damaged", f" {waiting} of other inputs"):
        assert count in line
    assert taker.stages() == ["gait"]
    assert taker.table.read_text() == giver.table.read_text()


def test_no_remote_fails_a_run(giver):
    run = giver.snakemake(TABLE, "-n", hydra=f"{QUIET} store.remote=/nowhere")
    assert run.returncode == 0, run.stderr
    (line,) = [line for line in run.stderr.splitlines() if "slider: remote /nowhere: " in line]
    assert line.endswith("; what is missing is computed here")
