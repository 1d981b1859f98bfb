"""The real Snakemake takes what another one computed, and computes what it cannot take."""

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

NOTHING = "Nothing to be done"


@pytest.fixture(scope="module")
def giver(session_folder, tmp_path_factory) -> Workspace:
    """A pipeline of dummies that ran and pushed all to a folder beside it."""
    workspace = dummies_that_ran(session_folder, tmp_path_factory.mktemp("giver") / "once")
    pushed = workspace.slider("store", "push", str(workspace.folder / "remote"))
    assert pushed.stdout.startswith(f"push to {workspace.folder}/remote: {len(EVERYTHING)} sent (")
    return workspace


def test_the_pipeline_takes_what_it_needs_and_computes_what_is_damaged(giver, tmp_path):
    remote = giver.folder / "remote"
    hydra = f"{QUIET} store.remote={remote}"
    taker = with_dummies(copy_repository(tmp_path / "taker"))
    run = taker.snakemake(TABLE, hydra=hydra)
    assert run.returncode == 0, run.stderr
    assert taker.stages() == []
    assert taker.table.read_text() == giver.table.read_text()
    (line,) = [line for line in run.stderr.splitlines() if str(remote) in line and "from" in line]
    assert line.startswith(f"slider: from {remote}: {len(EVERYTHING)} taken, ")
    assert NOTHING in taker.snakemake(TABLE, "-n", hydra=hydra).stdout

    table = giver.manifests("gait")[0]["files"]
    (remote / "files" / table["gait.txt"]["sha256"]).write_bytes(b"")
    other = with_dummies(copy_repository(tmp_path / "other"))
    run = other.snakemake(TABLE, hydra=hydra)
    assert run.returncode == 0, run.stderr
    assert f"damaged in {remote}: expected the content of gait.txt, found another" in run.stderr
    assert other.stages() == ["gait"]  # the rest waited in the index for the same gait
    assert other.table.read_text() == giver.table.read_text()


@pytest.mark.parametrize("remote", ["/nowhere", "http://127.0.0.1:1", "http://[::1"])
def test_no_remote_fails_a_run(remote, giver):
    hydra = f"{QUIET} 'store.remote=\"{remote}\"' train.walking.iterations=7"
    run = giver.snakemake(TABLE, "-n", hydra=hydra)
    assert run.returncode == 0, run.stderr
    (line,) = [line for line in run.stderr.splitlines() if f"slider: remote {remote}: " in line]
    assert line.endswith("; what is missing is computed here")
