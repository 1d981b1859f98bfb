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


@pytest.fixture
def taker(tmp_path) -> Workspace:
    """The same pipeline, of which nothing ran."""
    return with_dummies(copy_repository(tmp_path))


def test_a_colleague_has_the_table_with_no_stage_computed(giver, taker):
    assert taker.snakemake(TABLE, "-n", hydra=QUIET).returncode == 0  # writes the plan
    assert taker.slider("store", "pull", str(giver.folder / "remote")).returncode == 0
    assert taker.computed() == []
    assert taker.table.read_text() == giver.table.read_text()
    assert NOTHING in taker.snakemake(TABLE, "-n", hydra=QUIET).stdout


def test_the_pipeline_takes_what_it_needs_itself(giver, taker):
    remote = giver.folder / "remote"
    run = taker.snakemake(TABLE, hydra=f"{QUIET} store.remote={remote}")
    assert run.returncode == 0, run.stderr
    assert taker.stages() == []
    assert taker.table.read_text() == giver.table.read_text()
    (line,) = [line for line in run.stderr.splitlines() if str(remote) in line and "from" in line]
    assert line.startswith(f"slider: from {remote}: {len(EVERYTHING)} taken, ")
    assert taker.slider("store", "verify").returncode == 0
    run = taker.snakemake(TABLE, "-n", hydra=f"{QUIET} store.remote={remote}")
    assert NOTHING in run.stdout
    assert str(remote) not in run.stderr


def test_a_damaged_gait_alone_is_solved_again(giver, taker):
    """What was computed from it waits in the index, and counts since the gait is the same."""
    remote = taker.folder / "remote"
    taker.snakemake(TABLE, "-n", hydra=QUIET)
    taker.slider("store", "pull", str(giver.folder / "remote"))
    taker.slider("store", "push", str(remote))
    digest = taker.manifests("gait")[0]["object"]
    (remote / "archives" / f"{digest}.tar").write_bytes(b"")
    other = with_dummies(copy_repository(taker.folder / "other"))
    run = other.snakemake(TABLE, hydra=f"{QUIET} store.remote={remote}")
    assert run.returncode == 0, run.stderr
    assert f"damaged in {remote}: expected 10240 bytes, found 0" in run.stderr
    assert other.stages() == ["gait"]
    assert other.table.read_text() == giver.table.read_text()


@pytest.mark.parametrize("remote", ["/nowhere", "http://127.0.0.1:1", "s3://x/y", "quatsch://x"])
def test_no_remote_fails_a_run(remote, giver):
    hydra = f"{QUIET} store.remote={remote} train.walking.iterations=7"
    run = giver.snakemake(TABLE, "-n", hydra=hydra, AWS_ENDPOINT_URL="http://127.0.0.1:1")
    assert run.returncode == 0, run.stderr
    (line,) = [line for line in run.stderr.splitlines() if f"slider: remote {remote}: " in line]
    assert line.endswith("; what is missing is computed here")
