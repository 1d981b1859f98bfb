"""Maps show the numbers of their tables, gait by gait."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from slider.core.errors import UserError
from slider.core.job import Job
from slider.hzd.summary import CSV, QUANTITIES, write_csv
from slider.library.reader import GaitLibrary
from slider.reports.figures import STABILITY_FILES
from slider.reports.figures.checks import (
    MAPS,
    NAME,
    TABLE,
    by_gait,
    run_stability,
    run_verification,
)
from slider.robot.names import VELOCITY
from slider.verification.quantities import QUANTITIES as CHECKS
from tests.library.gaits import write_store

GAITS = [(0.0, 0.0, 0.0), (0.5, 0.0, 0.0), (0.5, 0.1, 0.0)]


@pytest.fixture(scope="module")
def inputs(tmp_path_factory) -> dict[str, list[Path]]:
    folder = tmp_path_factory.mktemp("stability")
    store = write_store(folder / "library", GAITS, []).parent
    frame = pd.DataFrame(GAITS, columns=[*VELOCITY]).assign(**dict.fromkeys(QUANTITIES, 1.5))
    frame.loc[2, list(QUANTITIES)] = np.nan  # it has no limit cycle
    write_csv(folder / CSV, frame)
    return {"library": [store], "stability": [folder]}


def drawn(run, inputs: dict[str, list[Path]], out: Path) -> set[str]:
    """Names of the files."""
    run({}, inputs, out, Job(out))
    return {path.name for path in out.iterdir()}


def test_stability_is_drawn(inputs, tmp_path):
    assert drawn(run_stability, inputs, tmp_path) == set(STABILITY_FILES)


CHECKED = [(0.0, -0.1, 0.0), (0.0, 0.0, 0.0), (0.5, 0.0, 0.0)]


def table(folder: Path, gaits: list[tuple[float, float, float]]) -> Path:
    """Values that tell gait and quantity: 100 · row + column; one does not apply."""
    folder.mkdir()
    values = 100.0 * np.arange(len(gaits))[:, None] + np.arange(len(CHECKS)) + 1
    rows = pd.DataFrame(np.hstack([gaits, values]), columns=[*VELOCITY, *CHECKS])
    rows.loc[2:, "dense_cop"] = np.nan
    rows.assign(failed="").to_csv(folder / TABLE, index=False)
    return folder


@pytest.fixture(scope="module")
def store(tmp_path_factory) -> Path:
    return write_store(tmp_path_factory.mktemp("maps"), CHECKED, []).parent


def test_values_belong_to_their_gaits(store, tmp_path):
    checked = table(tmp_path / "checked", CHECKED[::-1])  # in another order than the library's
    library = GaitLibrary.load(store / "library.zarr")
    found = by_gait(library, checked / TABLE)["dense_leg_distance"]
    place = list(CHECKS).index("dense_leg_distance") + 1
    order = [CHECKED[::-1].index(tuple(command)) for command in library.velocities.tolist()]
    np.testing.assert_array_equal(found, 100 * np.array(order) + place)
    assert set(MAPS) <= CHECKS.keys()


def test_maps_of_the_verification_are_two_files(store, tmp_path):
    inputs = {"library": [store], "verification": [table(tmp_path / "checked", CHECKED)]}
    (tmp_path / "out").mkdir()
    assert drawn(run_verification, inputs, tmp_path / "out") == {f"{NAME}.svg", f"{NAME}.md"}


def test_a_gait_without_checks_is_refused(store, tmp_path):
    checked = table(tmp_path / "checked", CHECKED[:2])
    with pytest.raises(UserError, match=r"expected a row of the gait \(0.5, 0\) m/s, found none"):
        drawn(run_verification, {"library": [store], "verification": [checked]}, tmp_path)
