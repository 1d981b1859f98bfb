"""The stages: tables of gaits in any grouping, holes, whose dynamics."""

import csv
import shutil
from functools import partial

import numpy as np
import pytest
import zarr

from slider.core.errors import UserError
from slider.core.job import Job
from slider.hzd import walk
from slider.hzd.foot_placement import FootPlacement
from slider.hzd.stability import CSV, MARKDOWN, QUANTITIES, records, run
from slider.hzd.stage import collect_placement
from slider.hzd.walk import limit_cycles
from slider.robot.names import VELOCITY
from tests.gait.gaits import config
from tests.hzd.sample import CLOCK, HIP, HOLE, VELOCITIES, chunk, folder, library, place, steps


def test_records_hold_every_quantity():
    record, _ = records(library(), chunk())
    assert {*QUANTITIES, *VELOCITY} == record.keys()
    assert (record["vx"], record["vy"], record["phase"]) == (0.6, 0.1, "hip")
    assert record["closed_spectral_radius"] < 0.6 < 1.4 < record["spectral_radius"]
    assert record["spectral_radius"] == record["eigenvalues"][0]
    assert 0.8 < record["hip_share"] < 1.0
    velocity = np.array([plan.hip.slopes[HIP, :, 0] for plan in steps()])
    mean = np.trapezoid(velocity, dx=1 / (velocity.shape[1] - 1), axis=1)
    expected = (velocity.min(axis=1) / mean).min()
    assert record["hip_share"] == pytest.approx(expected, rel=1e-3)
    assert record["decoupling"] > config().gait.decoupling_min


def test_tables_are_in_the_order_of_the_library(tmp_path):
    with pytest.raises(UserError, match=r"expected velocities.npy of the foot placement"):
        FootPlacement.load(tmp_path)
    collect_placement({}, {"library": [folder()], "gaits": [chunk()]}, tmp_path, Job(tmp_path))
    found = FootPlacement.load(tmp_path)
    np.testing.assert_array_equal(found.velocities, library().velocities)
    assert found.clock.tolist() == [True, False]
    assert found.gains.shape == (2, 2, 2, 21, 2, 4)
    by_time, by_hip = 0, 1
    assert found.gains[HIP, by_time, ..., 0, 3].all()
    by_clock = found.gains[CLOCK, ..., :3]
    np.testing.assert_array_equal(by_clock[by_time], by_clock[by_hip])
    assert not found.gains[:, by_hip, ..., 3].any()
    np.testing.assert_array_equal(found.gains[::-1], FootPlacement.load(chunk()).gains)
    np.testing.assert_allclose(found.gains[HIP, by_hip, :, 0, 1, 0], -2.1, atol=0.3)
    np.testing.assert_array_equal(found.placement[:, 1], steps()[1].placement)
    np.testing.assert_array_equal(found.hip[:, 0, :, 1:2], steps()[0].hip.slopes)


def test_the_table_has_a_line_per_gait(tmp_path):
    inputs = {"library": [folder()], "gaits": [chunk()]}
    assert run({}, inputs, tmp_path, Job(tmp_path)) == {"gaits": 2, "stable": 2}
    rows = list(csv.DictReader((tmp_path / CSV).read_text().splitlines()))
    assert [tuple(float(row[name]) for name in VELOCITY) for row in rows] == VELOCITIES
    assert [len(row["eigenvalues"].split()) for row in rows] == [4, 3]
    assert rows[0]["hip_share"] == ""
    assert "| `spectral_radius` | 1/step |" in (tmp_path / MARKDOWN).read_text()


def test_a_job_of_holes_has_tables_of_no_gaits(tmp_path):
    assert place(tmp_path, HOLE) == []
    assert len(FootPlacement.load(tmp_path).velocities) == 0
    out = tmp_path / "whole"
    out.mkdir()
    inputs = {"library": [folder()], "gaits": [tmp_path, chunk()]}
    assert collect_placement({}, inputs, out, Job(out)) == {"gaits": 2}
    assert records(library(), tmp_path) == []


def test_a_gait_without_limit_cycle_has_the_gaits_own_footholds_and_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(walk, "limit_cycles", partial(limit_cycles, rounds=2))  # 20 find none, too
    said = place(
        tmp_path, VELOCITIES[CLOCK], linearisation={"difference": 1e-5, "tolerance": 1e-300}
    )
    expected = "gait (0.2, 0) m/s: no foot placement by time: expected a limit cycle, found none"
    assert said == [expected]
    assert not FootPlacement.load(tmp_path).gains.any()
    (record,) = records(library(), tmp_path)
    assert "spectral_radius" not in record


def test_gaits_of_the_virtual_knee_are_refused(tmp_path):
    copy = tmp_path / "library"
    shutil.copytree(folder(), copy)
    zarr.open_group(copy / "library.zarr", mode="a").attrs["dynamics"] = "knee"
    with pytest.raises(UserError, match=r"expected gaits of the prismatic leg .* found knee"):
        place(tmp_path, *VELOCITIES, store=copy)
