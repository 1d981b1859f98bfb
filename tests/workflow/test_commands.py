"""A remote beside the real Snakemake."""

import pytest

from tests.workflow.workspace import EVERYTHING, QUIET, TABLE, copy_repository, with_dummies

pytestmark = pytest.mark.workflow


def test_the_pipeline_takes_what_it_needs_and_computes_what_is_damaged(workspace, tmp_path):
    giver, remote = workspace, tmp_path / "remote"
    pushed = giver.slider("store", "push", str(remote))
    assert pushed.stdout.startswith(f"push to {remote}: {len(EVERYTHING)} sent (")
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
