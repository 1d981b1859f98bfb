"""The stages: records and tables of gaits in any grouping, holes, whose dynamics."""

import csv
import json
import shutil
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import zarr

from pipeline.stages.gaits import stability_jobs
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import Code
from slider.core.errors import UserError
from slider.core.job import Job
from slider.hzd import walk
from slider.hzd.gains import FootPlacement
from slider.hzd.stability import RECORDS, run, run_basin, run_maps
from slider.hzd.stage import collect_placement, run_gaits
from slider.hzd.summary import CSV, MARKDOWN, QUANTITIES
from slider.hzd.walk import limit_cycles
from slider.robot.names import VELOCITY
from tests.gait.gaits import config
from tests.hzd.sample import CLOCK, HIP, VELOCITIES, folder, library, steps

HOLE = (0.9, 0.0, 0.0)


def jobs() -> dict[str, JobSpec]:
    code = Code("", "", {})
    solves = [JobSpec("gait", "", code, {"velocity": list(v)}) for v in [*VELOCITIES, HOLE]]
    return stability_jobs(config(), JobSpec("library", "", code, {}, {"gaits": solves}))


def placed(out: Path, *velocities: tuple[float, float, float], **changes) -> list[str]:
    """What a job of foot placement says."""
    (spec,) = jobs()["foot_placement"].inputs["gaits"]
    section = {**spec.section, "velocities": [list(v) for v in velocities]}
    section["hzd"] = spec.section["hzd"] | changes
    said = []
    run_gaits(section, {"library": [folder()]}, out, Job(out, progress=said.append))
    return said


@pytest.fixture(scope="module")
def chunk(tmp_path_factory) -> Path:
    """Of both gaits, the faster one first, and of a hole."""
    out = tmp_path_factory.mktemp("chunk")
    assert placed(out, *VELOCITIES[::-1], HOLE) == []
    return out


@pytest.fixture(scope="module")
def maps(chunk, tmp_path_factory) -> Path:
    """Return maps of the same gaits."""
    (spec,) = jobs()["stability"].inputs["gaits"]
    out = tmp_path_factory.mktemp("maps")
    velocities = [list(v) for v in [*VELOCITIES[::-1], HOLE]]
    inputs = {"library": [folder()], "gaits": [chunk]}
    run_maps({**spec.section, "velocities": velocities}, inputs, out, Job(out))
    return out


def test_records_hold_every_quantity(maps):
    record, _ = json.loads((maps / RECORDS).read_text())
    assert {*QUANTITIES, *VELOCITY} == record.keys()
    assert (record["vx"], record["vy"], record["phase"]) == (0.6, 0.1, "hip")
    assert record["closed_spectral_radius"] < 0.6 < 2.0 < record["spectral_radius"]
    np.testing.assert_allclose(record["spectral_radius"], record["eigenvalues"][0], rtol=1e-3)
    assert 0.8 < record["hip_share"] < 1.0
    assert record["decoupling"] > config().gait.decoupling_min


def test_tables_are_in_the_order_of_the_library(chunk, tmp_path):
    with pytest.raises(UserError, match=r"expected velocities.npy of the foot placement"):
        FootPlacement.load(tmp_path)
    collect_placement({}, {"library": [folder()], "gaits": [chunk]}, tmp_path, Job(tmp_path))
    found = FootPlacement.load(tmp_path)
    np.testing.assert_array_equal(found.velocities, library().velocities)
    assert found.clock.tolist() == [True, False]
    assert found.gains.shape == (2, 2, 2, 21, 2, 4)
    by_time, by_hip = 0, 1
    assert found.gains[HIP, by_time, ..., 0, 3].all()
    by_clock = found.gains[CLOCK, ..., :3]
    np.testing.assert_array_equal(by_clock[by_time], by_clock[by_hip])
    assert not found.gains[:, by_hip, ..., 3].any()
    np.testing.assert_array_equal(found.gains[::-1], FootPlacement.load(chunk).gains)
    np.testing.assert_allclose(found.gains[HIP, by_hip, :, 0, 1, 0], -2.1, atol=0.3)
    np.testing.assert_array_equal(found.placement[:, 1], steps()[1].placement)
    np.testing.assert_array_equal(found.hip[:, 0, :, 1:2], steps()[0].hip.slopes)


def test_the_table_has_a_line_per_gait(maps, tmp_path):
    assert run({}, {"gaits": [maps]}, tmp_path, Job(tmp_path)) == {"gaits": 2, "stable": 2}
    rows = list(csv.DictReader((tmp_path / CSV).read_text().splitlines()))
    assert [tuple(float(row[name]) for name in VELOCITY) for row in rows] == VELOCITIES
    assert [len(row["eigenvalues"].split()) for row in rows] == [4, 3]
    assert rows[0]["hip_share"] == ""
    assert "| `spectral_radius` | 1/step |" in (tmp_path / MARKDOWN).read_text()


def test_a_job_of_holes_has_tables_of_no_gaits(chunk, tmp_path):
    assert placed(tmp_path, HOLE) == []
    assert len(FootPlacement.load(tmp_path).velocities) == 0
    out = tmp_path / "whole"
    out.mkdir()
    inputs = {"library": [folder()], "gaits": [tmp_path, chunk]}
    assert collect_placement({}, inputs, out, Job(out)) == {"gaits": 2}
    (spec,) = jobs()["stability"].inputs["gaits"]
    section = {**spec.section, "velocities": [list(HOLE)]}
    found = run_maps(section, {"library": [folder()], "gaits": [tmp_path]}, out, Job(out))
    assert found == {"gaits": 0, "limit_cycles": 0}
    assert json.loads((out / RECORDS).read_text()) == []


def test_a_gait_without_limit_cycle_has_the_gaits_own_footholds_and_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(walk, "limit_cycles", partial(limit_cycles, rounds=2))  # 20 find none, too
    said = placed(
        tmp_path, VELOCITIES[CLOCK], linearisation={"difference": 1e-5, "tolerance": 1e-300}
    )
    expected = "gait (0.2, 0) m/s: no foot placement by time: expected a limit cycle, found none"
    assert said == [expected]
    assert not FootPlacement.load(tmp_path).gains.any()


def test_a_basin_and_its_walks(tmp_path):
    (spec,) = jobs()["foot_placement"].inputs["gaits"]
    basin = {"roll": {"lower": -0.02, "upper": 0.02}, "roll_rate": {"lower": -0.2, "upper": 0.2}}
    basin |= {"points": 3, "steps": 12, "returned": [0.02, 0.1]}
    section = {"hzd": spec.section["hzd"], "basin": basin, "velocity": list(VELOCITIES[HIP])}
    found = run_basin(section, {"library": [folder()]}, tmp_path, Job(tmp_path))
    assert found["with"] == 9 > 4 >= found["without"]
    assert (np.load(tmp_path / "with.npy") > 0).all()
    assert np.load(tmp_path / "walk_with.npy").shape == (12 * 21, 2)


def test_gaits_of_the_virtual_knee_are_refused(tmp_path):
    copy = tmp_path / "library"
    shutil.copytree(folder(), copy)
    zarr.open_group(copy / "library.zarr", mode="a").attrs["dynamics"] = "knee"
    (spec,) = jobs()["foot_placement"].inputs["gaits"]
    with pytest.raises(UserError, match=r"expected gaits of the prismatic leg .* found knee"):
        run_gaits(spec.section, {"library": [copy]}, tmp_path, Job(tmp_path))
