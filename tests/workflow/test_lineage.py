"""``slider why`` and ``slider diff`` after dry runs of the real Snakemake."""

import pytest

from tests.workflow.workspace import AFTER_STANDING, EVERYTHING, dummies_that_ran

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
