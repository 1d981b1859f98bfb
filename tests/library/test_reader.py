"""Reading the library: what is refused and which velocity is which gait."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import zarr

from slider.core.errors import UserError
from slider.library.reader import CONSTRAINT, GaitLibrary
from tests.library.gaits import write_store

GAITS, HOLES = [(0.0, 0.0), (0.5, 0.1)], [(0.5, 0.0)]


@pytest.fixture(scope="module")
def store(tmp_path_factory) -> Path:
    return write_store(tmp_path_factory.mktemp("library"), GAITS, HOLES)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda group: shutil.rmtree(group.store.root), "expected a gait library at {}, found"),
        (lambda group: group.attrs.update(schema="x"), "expected a gait library at {}, found the"),
        (lambda group: group.attrs.update(version=1), "{}: expected version 5 of the gait library"),
        (lambda group: group.__delitem__("samples"), "{}: expected 'samples' in the gait library"),
        (lambda group: group.__delitem__(CONSTRAINT), "{}: expected 'constraint' in the gait"),
        (lambda group: group.attrs.__delitem__("holes"), "{}: expected 'holes' in the gait"),
    ],
)
def test_what_is_no_library_is_refused_in_one_line(store, tmp_path: Path, change, message):
    path = tmp_path / "changed.zarr"
    shutil.copytree(store, path)
    change(zarr.open_group(path, mode="a"))
    with pytest.raises(UserError) as error:
        GaitLibrary.load(path)
    assert str(error.value).startswith(message.format(path))
    assert "\n" not in str(error.value)


def test_find_names_the_nearest_velocity_and_why_a_hole_is_one(store):
    library = GaitLibrary.load(store)
    assert library.find(0.5, 0.1) == 1
    with pytest.raises(
        UserError, match=r"found \(0\.1, -0\.2\) m/s; the nearest gait is at \(0, 0\)"
    ):
        library.find(0.1, -0.2)
    with pytest.raises(UserError, match=r"did not converge: Infeasible.*torso 0\.3, .*; impact"):
        library.find(0.5, 0.0)


def test_a_library_that_turns_is_searched_by_yaw_rate(tmp_path):
    velocities = [(0.5, 0.0, rate) for rate in (-0.3, 0.0, 0.3)] + [(0.6, 0.0, 0.0)]
    library = GaitLibrary.load(write_store(tmp_path, velocities, [(0.6, 0.0, 0.3)]))
    assert library.find(0.5, 0.0, 0.3) == 2
    assert library.find(0.5, 0.0) == 1
    nearest = r"the nearest gait is at \(0\.5, 0\) m/s, 0\.3 rad/s"
    with pytest.raises(UserError, match=r"found \(0\.5, 0\) m/s, 0\.4 rad/s; " + nearest):
        library.find(0.5, 0.0, 0.4)
    with pytest.raises(UserError, match=r"\(0\.6, 0\) m/s, 0\.3 rad/s did not converge"):
        library.find(0.6, 0.0, 0.3)
    np.testing.assert_array_equal(library.straight.velocities, [velocities[1], velocities[3]])
    assert library.straight.holes == ()
    assert library.straight.straight is library.straight
