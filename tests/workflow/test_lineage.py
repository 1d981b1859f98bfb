"""``slider lineage`` beside the real Snakemake: it says what Snakemake then does."""

import json
from pathlib import Path

import pytest

from tests.workflow.workspace import (
    AFTER_STANDING,
    EVERYTHING,
    QUIET,
    TABLE,
    Workspace,
    dummies_that_ran,
)

pytestmark = pytest.mark.workflow

LONGER = "train.walking.iterations=5"


@pytest.fixture(scope="module")
def once(session_folder, tmp_path_factory) -> Workspace:
    return dummies_that_ran(session_folder, tmp_path_factory.mktemp("lineage") / "once")


@pytest.fixture
def workspace(once, tmp_path) -> Workspace:
    return once.copy(tmp_path / "copy")


def why(workspace: Workspace, *overrides: str, target: str = TABLE) -> list[str]:
    arguments = ("lineage", "why", target, "experiment=test", *overrides)
    done = workspace.slider(*arguments)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def stages(workspace: Workspace, *overrides: str) -> list[str]:
    arguments = ("lineage", "why", "table1", "experiment=test", *overrides, "--json")
    jobs = json.loads(workspace.slider(*arguments).stdout)["jobs"]
    return sorted(job["stage"] for job in jobs if not job["reused"])


def test_why_is_what_snakemake_then_computes(workspace):
    assert why(workspace) == ["table1: nothing to compute"]
    assert why(workspace, LONGER)[:2] == [
        "table1: 4 to compute",
        "  walking: train.walking.iterations 3 → 5",
    ]
    assert stages(workspace, LONGER) == AFTER_STANDING
    assert workspace.computed(LONGER) == AFTER_STANDING
    assert why(workspace, LONGER) == ["table1: nothing to compute"]
    module = "src/slider/gait/tiny.py"
    workspace.edit(module, "sum(section['command'])", "sum(section['command']) + 0.5")
    assert why(workspace, LONGER)[1] == "  gait × 2: source module slider.gait.tiny changed"
    assert stages(workspace, LONGER) == EVERYTHING
    assert workspace.computed(LONGER) == EVERYTHING


def test_a_damaged_object_is_why(workspace):
    (digest,) = workspace.objects("walking")
    (file,) = workspace.artefacts.glob(f"objects/*/{digest}/policy.txt")
    file.chmod(0o600)
    file.write_text("9")
    assert why(workspace) == ["table1: nothing to compute"]
    assert workspace.computed() == []
    assert why(workspace, target="policy") == [
        "walking: 1 to compute",
        "  walking: object damaged or missing",
    ]


def test_diff_of_two_configurations_and_of_two_stores(workspace, tmp_path):
    other = workspace.copy(tmp_path / "other")
    sides = ["experiment=test train.walking.seed=1", "experiment=test train.walking.seed=2"]
    diff = workspace.slider("lineage", "diff", *sides)
    assert (diff.returncode, diff.stderr) == (1, "")
    assert diff.stdout.splitlines()[1:] == ["  walking: train.walking.seed 1 → 2"]
    assert workspace.slider("lineage", "diff", sides[0], sides[0]).returncode == 0
    there = f"{other.artefacts}:table1"
    assert workspace.slider("lineage", "diff", "table1", there).returncode == 0
    assert other.computed(LONGER) == AFTER_STANDING
    diff = workspace.slider("lineage", "diff", TABLE, there, "--json")
    values = json.loads(diff.stdout)
    assert (diff.returncode, values["same"]) == (1, False)
    (cause,) = values["differences"]
    assert (cause["name"], cause["old"], cause["new"]) == ("train.walking.iterations", "3", "5")
    stored = workspace.slider("lineage", "diff", "table1", f"experiment=test {LONGER}")
    assert stored.stdout.splitlines()[1:] == ["  walking: train.walking.iterations 3 → 5"]


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (("show", "tabel1"), 1, "found 'tabel1'; did you mean table1"),
        (("diff", "table1", "tabel1"), 2, "found 'tabel1'; did you mean table1"),
        (
            ("diff", "experiment=test", "experiment=test train.seed=2"),
            2,
            "unknown configuration key",
        ),
        (("why", "table1", "train.seed=2"), 1, "unknown configuration key"),
        (("why", "table1", "'train"), 1, "No closing quotation"),
        (("why", "tabel1", "experiment=test"), 1, "found 'tabel1'; did you mean table1"),
    ],
)
def test_bad_input_is_one_line(once, arguments, code, text):
    done = once.slider("lineage", *arguments)
    assert (done.returncode, done.stdout) == (code, "")
    assert text in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("slider: ")


def test_looking_writes_nothing(workspace):
    """But for the integrity index of objects that it read, once they are old enough."""

    def present() -> list[Path]:
        return sorted(p for p in workspace.artefacts.rglob("*") if "integrity" not in p.parts)

    before = present()
    assert workspace.slider("lineage", "show", "table1").returncode == 0
    assert workspace.slider("lineage", "diff", "table1", "experiment=test").returncode == 0
    why(workspace, LONGER)
    assert present() == before
    assert workspace.computed(QUIET) == []


def test_overrides_without_the_job_are_unknown(once):
    gaits = json.loads(once.slider("lineage", "show", "library", "--json").stdout)["jobs"].values()
    (*_, last) = [job for job in gaits if job["stage"] == "gait"]
    other = "experiment=test gait.grid.vx.stop=0.0 gait.grid.vx.start=0.0"
    done = once.slider("lineage", "diff", last["recipe"], other)
    assert (done.returncode, done.stdout) == (2, "")
    expected = f"expected a configuration with {last['label']}, found one without"
    assert done.stderr == f"slider: {expected}\n"
