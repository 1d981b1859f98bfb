"""Studies, bundles, remotes, ``slider why`` and ``slider diff`` beside the real Snakemake."""

import shlex
import shutil
import subprocess
import zipfile

import pytest

from tests.workflow.workspace import (
    AFTER_STANDING,
    EVERYTHING,
    QUIET,
    REPOSITORY,
    TABLE,
    Workspace,
    copy_repository,
    dummies_that_ran,
    finished,
    with_dummies,
)

pytestmark = pytest.mark.workflow

LONGER = "train.walking.iterations=5"


def test_why_is_what_snakemake_then_computes(session_folder, tmp_path):
    workspace = dummies_that_ran(session_folder, tmp_path / "copy")

    def why(*overrides: str) -> list[str]:
        workspace.snakemake("-n", hydra=" ".join(overrides))
        done = workspace.slider("why", "table1")
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()

    assert why() == ["table1: nothing to compute"]
    assert why(LONGER)[:2] == [
        f"table1: {len(AFTER_STANDING)} to compute",
        "  walking: train.walking.iterations 3 → 5",
    ]
    diff = workspace.slider("diff", "previous", "latest")
    assert diff.returncode == 1
    assert diff.stdout.splitlines()[1:] == ["  walking: train.walking.iterations 3 → 5"]
    assert workspace.computed(LONGER) == AFTER_STANDING
    assert why(LONGER) == ["table1: nothing to compute"]
    workspace.edit(
        "src/slider/gait/tiny.py", "sum(section['velocity'])", "sum(section['velocity']) + 0.5"
    )
    assert why(LONGER)[:2] == [
        f"table1: {len(EVERYTHING)} to compute",
        "  gait × 2: source slider.gait.tiny changed",
    ]


def test_a_study_computes_what_is_new_and_a_file_is_a_study(session_folder, tmp_path):
    workspace = finished(session_folder).copy(tmp_path / "copy")
    reports = workspace.folder / "reports"
    target = "reports/sensitivity.csv"
    assert workspace.computed(target=target) == sorted(
        [*["gait"] * 8, *["evaluation"] * 6, "study"]
    )
    assert len((reports / "sensitivity_runs.csv").read_text().splitlines()) == 1 + 2 * (1 + 4)
    assert (reports / "figures/sensitivity.svg").is_file()
    assert workspace.computed(target=target) == []
    starts = "reports/gait_starts.csv"
    assert workspace.computed(target=starts) == ["gait_start", "gait_start", "study"]
    more = workspace.computed("study.gait_starts.starts.count=3", target=starts)
    assert more == ["gait_start", "study"]
    text = "defaults: [gait_starts, _self_]\nstarts: {count: 3}\nspeeds: [0.4]\n"
    (workspace.folder / "conf/study/mine.yaml").write_text(text)
    spread = "study.mine.starts.spread.joints=0.05"
    assert workspace.computed(spread, target="reports/mine.csv") == ["study"]


def test_the_unpacked_project_has_the_plan_of_the_results(tmp_path):
    workspace = with_dummies(copy_repository(tmp_path / "project"))
    shutil.copy(REPOSITORY / "CITATION.cff", workspace.folder)
    (workspace.folder / ".gitignore").write_text("/artefacts\n/reports\n.snakemake\n__pycache__\n")
    workspace.computed(hydra="train.walking.iterations=5")
    for command in (["init", "-q"], ["add", "-A"]):
        subprocess.run(["git", "-C", workspace.folder, *command], check=True)
    done = workspace.slider("bundle", "table1")
    assert (done.returncode, done.stderr) == (0, "")
    printed = done.stdout.splitlines()[-1].removeprefix("unpacked, this has the results: ")
    with zipfile.ZipFile(workspace.folder / "reports" / "table1.crate.zip") as archive:
        archive.extractall(tmp_path / "unpacked")
    unpacked = Workspace(tmp_path / "unpacked")
    before = unpacked.stages()
    words = shlex.split(printed)
    assert words[0] == "snakemake"
    again = unpacked.command(["-m", *words])
    assert again.returncode == 0, again.stderr
    assert unpacked.table.read_text() == workspace.table.read_text()
    assert unpacked.stages() == before


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
    assert "Nothing to be done" in taker.snakemake(TABLE, "-n", hydra=hydra).stdout

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
