"""The maps of the verification show the numbers of its table, gait by gait."""

import csv
from pathlib import Path

import numpy as np
import pytest

from slider.core.errors import UserError
from slider.core.job import Job
from slider.library.reader import GaitLibrary
from slider.reports.figures.verification_maps import MAPS, NAME, TABLE, gait_values, read_table, run
from slider.verification.quantities import QUANTITIES
from tests.library.gaits import write_store

GAITS = [(0.0, -0.1, 0.0), (0.0, 0.0, 0.0), (0.5, 0.0, 0.0)]


def table(folder: Path, gaits: list[tuple[float, float, float]]) -> Path:
    """Values that tell gait and quantity: 100 · row + column; one does not apply."""
    folder.mkdir()
    with (folder / TABLE).open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["vx", "vy", "yaw_rate", *QUANTITIES, "failed"])
        for k, command in enumerate(gaits):
            values = [100 * k + i + 1 for i in range(len(QUANTITIES))]
            blank = list(QUANTITIES).index("regulated_steps")
            row = [*values[:blank], "" if k == 2 else values[blank], *values[blank + 1 :]]
            writer.writerow([*command, *row, ""])
    return folder


@pytest.fixture(scope="module")
def store(tmp_path_factory) -> Path:
    return write_store(tmp_path_factory.mktemp("maps"), GAITS, []).parent


def test_values_belong_to_their_gaits(store, tmp_path):
    checked = table(tmp_path / "checked", GAITS[::-1])  # in another order than the library's
    library = GaitLibrary.load(store / "library.zarr")
    found = gait_values(library, read_table(checked / TABLE), "return_map")
    place = list(QUANTITIES).index("return_map") + 1
    expected = {gait: 100 * k + place for k, gait in enumerate(GAITS[::-1])}
    np.testing.assert_array_equal(
        found, [expected[tuple(command)] for command in library.commands.tolist()]
    )
    assert set(MAPS) <= QUANTITIES.keys()


def test_draws_and_repeats_itself(store, tmp_path):
    checked = table(tmp_path / "checked", GAITS)
    files = []
    for name in ("one", "two"):
        out = tmp_path / name
        out.mkdir()
        run({}, {"library": [store], "verification": [checked]}, out, Job(out))
        files.append({path.name: path.read_bytes() for path in out.iterdir()})
    assert files[0] == files[1]
    assert set(files[0]) == {f"{NAME}.{suffix}" for suffix in ("svg", "png", "md")}


def test_a_gait_without_checks_is_refused(store, tmp_path):
    checked = table(tmp_path / "checked", GAITS[:2])
    with pytest.raises(UserError, match=r"expected the gait \(0.5, 0\) m/s, found none"):
        run({}, {"library": [store], "verification": [checked]}, tmp_path, Job(tmp_path))
