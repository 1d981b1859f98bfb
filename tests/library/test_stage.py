"""The stage ``library``: what is stored, that it is the same every time, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
import xarray
import zarr

from slider.config.convert import to_dict
from slider.core.errors import UserError
from slider.core.job import Job
from slider.library.reader import ARRAYS, GaitLibrary
from slider.library.stage import run
from tests.env.synthetic import CHANNELS
from tests.library.gaits import ROBOT, section, value, write_gait

VELOCITIES = [(0.0, 0.0), (0.5, 0.1), (1.0, -0.1)]


@pytest.fixture
def gaits(tmp_path: Path) -> list[Path]:
    return [write_gait(tmp_path / f"gait{i}", *v) for i, v in enumerate(VELOCITIES)]


@pytest.fixture
def with_a_hole(tmp_path: Path, gaits: list[Path]) -> list[Path]:
    bad = write_gait(
        tmp_path / "bad", 0.5, 0.1, converged=False, status="Infeasible_Problem_Detected",
        max_violation=0.3, residuals={"impact": 1e-3, "slide_force": 0.3},
    )  # fmt: skip
    return [gaits[0], bad, gaits[2]]


@pytest.fixture
def hostile(monkeypatch):
    """Variables that change how zarr writes and reads."""
    yield lambda: (
        monkeypatch.setenv("ZARR_JSON_INDENT", "7"),
        monkeypatch.setenv("ZARR_ARRAY__ORDER", "F"),
        monkeypatch.setenv("ZARR_ARRAY__WRITE_EMPTY_CHUNKS", "True"),
        zarr.config.refresh(),
    )
    monkeypatch.undo()
    zarr.config.refresh()


def test_same_gaits_give_the_same_bytes_whatever_zarr_is_told(gaits, tmp_path: Path, hostile):
    stores = []
    for name in ("one", "two"):
        run(section(), {"gaits": gaits}, tmp_path / name, Job(tmp_path))
        files = sorted(path for path in (tmp_path / name).rglob("*") if path.is_file())
        stores.append({path.relative_to(tmp_path / name): path.read_bytes() for path in files})
        hostile()
    assert zarr.config.get("array.order") == "F"
    assert stores[0] == stores[1]
    assert len(stores[0]) > len(ARRAYS)
    assert GaitLibrary.load(tmp_path / "one" / "library.zarr").arrays["samples"].flags.c_contiguous


def test_holes_are_refused_with_the_constraint_that_is_violated(with_a_hole, tmp_path: Path):
    """A gait that converged and violates too much is one; holes alone are no library."""
    loose = write_gait(tmp_path / "loose", 1.0, -0.1, max_violation=2e-6, residuals={"cone": 2e-6})
    worst = r"slide_force 0\.3, at most 0 \(3\.0e-01 beyond\); .*cone 2e-06"
    many = rf"^library: 2 of 4 .*\(0\.5, 0\.1\).*{worst}.*allow_holes"
    alone = r"^library: expected at least one gait, none of 1 converged: (?!.*allow_holes)"
    for gaits, allowed, message in (
        ([*with_a_hole, loose], False, many),
        (with_a_hole[1:2], True, alone),
    ):
        with pytest.raises(UserError, match=message):
            run(section(allowed), {"gaits": gaits}, tmp_path / "out", Job(tmp_path))


def test_an_allowed_hole_is_left_out_but_for_what_it_violates(with_a_hole, tmp_path: Path):
    summary = run(section(True), {"gaits": with_a_hole}, tmp_path / "out", Job(tmp_path))
    assert summary["holes"] == [[0.5, 0.1, 0.0]]
    contents = GaitLibrary.load(tmp_path / "out" / "library.zarr")
    np.testing.assert_array_equal(contents.velocities[:, :2], [VELOCITIES[0], VELOCITIES[2]])
    np.testing.assert_array_equal(contents.arrays["samples"][1], value("samples", 1.0, -0.1))
    (hole,) = contents.holes
    assert (hole.vx, hole.vy, hole.status) == (0.5, 0.1, "Infeasible_Problem_Detected")
    assert [text.split()[0] for text in hole.violated] == ["slide_force", "impact"]
    assert contents.constraints == ("impact", "torso")
    np.testing.assert_array_equal(contents.arrays["residuals"], [[1e-9, 0.0]] * 2)
    assert to_dict(contents.robot) == ROBOT
    assert contents.kinematic_map == "exact"
    assert contents.cost_unit == "N² m²/s"


def test_xarray_finds_named_dimensions_and_coordinates(gaits, tmp_path: Path):
    run(section(), {"gaits": gaits}, tmp_path / "out", Job(tmp_path))
    data = xarray.open_zarr(tmp_path / "out" / "library.zarr", consolidated=False)
    assert data["samples"].dims == ("gait", "sample", "channel")
    assert {"vx", "vy", "status", "channel", "joint", "knee_joint", "constraint"} <= set(
        data.coords
    )
    at = data.set_xindex(["vx", "vy"]).sel(vx=0.5, vy=0.1)
    found = at["samples"].sel(channel="left_slide.velocity").values.squeeze()
    expected = value("samples", 0.5, 0.1)[:, CHANNELS.index("left_slide.velocity")]
    np.testing.assert_array_equal(found, expected)
    assert data["efforts"].sel(joint="right_ankle").attrs["units"] == "N m, N (slide)"
    assert set(data.data_vars) == set(ARRAYS)
