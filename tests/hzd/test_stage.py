"""The stages: records and tables of gaits in any grouping, holes, whose dynamics."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import zarr

from pipeline.stages.stability import stability_jobs
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import Code
from slider.core.errors import UserError
from slider.core.job import Job
from slider.hzd.gains import FootPlacement
from slider.hzd.stage import (
    CSV,
    MARKDOWN,
    RECORDS,
    _stability,
    collect_placement,
    run,
    run_basin,
    run_gaits,
)
from slider.hzd.summary import QUANTITIES
from slider.robot.names import COMMAND
from tests.gait.gaits import config
from tests.hzd.sample import CLOCK, COMMANDS, HIP, folder, library, steps

HOLE = (0.9, 0.0, 0.0)


def jobs() -> dict[str, JobSpec]:
    code = Code("", "", {})
    solves = [JobSpec("gait", "", code, {"command": list(v)}) for v in [*COMMANDS, HOLE]]
    return stability_jobs(config(), JobSpec("library", "", code, {}, {"gaits": solves}))


@pytest.fixture(scope="module")
def chunk(tmp_path_factory) -> Path:
    """Of both gaits, the faster one first, and of a hole."""
    (spec,) = jobs()["stability"].inputs["gaits"]
    out = tmp_path_factory.mktemp("chunk")
    commands = [list(v) for v in [*COMMANDS[::-1], HOLE]]
    run_gaits(spec.section | {"commands": commands}, {"library": [folder()]}, out, Job(out))
    return out


def test_a_job_knows_only_what_it_uses():
    made = jobs()
    (spec,) = made["stability"].inputs["gaits"]
    assert spec.section["commands"] == [list(v) for v in [*COMMANDS, HOLE]]
    assert not {"basin", "chunk"} & spec.section["hzd"].keys()
    assert made["foot_placement"].inputs["gaits"] == made["stability"].inputs["gaits"]
    assert "basins" not in made["stability_figures"].inputs, "none of its gaits is in the library"


def test_records_hold_every_quantity(chunk):
    record, _ = json.loads((chunk / RECORDS).read_text())
    assert {*QUANTITIES, *COMMAND} == record.keys()
    assert (record["vx"], record["vy"], record["phase"]) == (0.6, 0.1, "hip")
    assert record["closed_spectral_radius"] < 0.6 < 2.0 < record["spectral_radius"]
    np.testing.assert_allclose(record["spectral_radius"], record["eigenvalues"][0], rtol=1e-3)
    assert 0.8 < record["hip_share"] < 1.0
    assert record["decoupling"] > config().gait.decoupling_min


def test_tables_are_in_the_order_of_the_library(chunk, tmp_path):
    collect_placement({}, {"library": [folder()], "gaits": [chunk]}, tmp_path, Job(tmp_path))
    found = FootPlacement.load(tmp_path)
    np.testing.assert_array_equal(found.commands, library().commands)
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


def test_the_table_has_a_line_per_gait(chunk, tmp_path):
    assert run({}, {"gaits": [chunk]}, tmp_path, Job(tmp_path)) == {"gaits": 2, "stable": 2}
    rows = list(csv.DictReader((tmp_path / CSV).read_text().splitlines()))
    assert [tuple(float(row[name]) for name in COMMAND) for row in rows] == COMMANDS
    assert [len(row["eigenvalues"].split()) for row in rows] == [4, 3]
    assert rows[0]["hip_share"] == ""
    assert "| `spectral_radius` | 1/step |" in (tmp_path / MARKDOWN).read_text()


def test_gaits_that_all_go_by_time(tmp_path):
    (spec,) = jobs()["stability"].inputs["gaits"]
    section = spec.section | {"commands": [list(COMMANDS[CLOCK])]}
    assert run_gaits(section, {"library": [folder()]}, tmp_path, Job(tmp_path))["gaits"] == 1


def test_a_basin_and_its_walks(tmp_path):
    (spec,) = jobs()["stability"].inputs["gaits"]
    basin = {"roll": {"lower": -0.02, "upper": 0.02}, "roll_rate": {"lower": -0.2, "upper": 0.2}}
    basin |= {"points": 2, "steps": 2, "returned": [0.02, 0.1]}
    section = {"hzd": spec.section["hzd"], "basin": basin, "command": list(COMMANDS[HIP])}
    found = run_basin(section, {"library": [folder()]}, tmp_path, Job(tmp_path))
    assert found["with"] > found["without"] == 0
    assert np.load(tmp_path / "with.npy").shape == (2, 2)
    assert np.load(tmp_path / "walk_with.npy").shape == (2 * 21, 2)


def test_a_gait_without_limit_cycle_has_no_numbers():
    record = _stability(None)
    assert set(record) <= QUANTITIES.keys()
    assert not any(record.values())


def test_gaits_of_the_virtual_knee_are_refused(tmp_path):
    copy = tmp_path / "library"
    shutil.copytree(folder(), copy)
    zarr.open_group(copy / "library.zarr", mode="a").attrs["dynamics"] = "knee"
    (spec,) = jobs()["stability"].inputs["gaits"]
    with pytest.raises(UserError, match=r"expected gaits of the prismatic leg .* found knee"):
        run_gaits(spec.section, {"library": [copy]}, tmp_path, Job(tmp_path))
