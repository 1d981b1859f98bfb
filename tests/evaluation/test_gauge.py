"""The gauge: levels that get harder, robots that pass, and a small run of a random policy."""

import json
import re
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from slider.config.convert import to_dict
from slider.config.evaluation import AXES, LEVELS, TERRAINS, GaugeProtocol
from slider.core.job import Job
from slider.evaluation import gauge
from slider.evaluation.gauge import count_passes, disturbed, with_noisier_sensors, words
from tests.control.policies import exported
from tests.env.synthetic import config

SETTINGS = config().gauge
ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("axis", AXES)
def test_levels_get_harder_and_each_has_its_own_words(axis):
    values = SETTINGS.values(axis)
    assert len(values) == LEVELS
    assert values == sorted(values, reverse=axis in ("friction", "motor_strength"))
    texts = [words(axis, value) for value in values]
    assert len(set(texts)) == LEVELS
    numbers = [float(re.sub(r"[^\d.]", "", text)) for text in texts]
    assert numbers == sorted(numbers, reverse=axis in ("friction", "motor_strength"))


@pytest.mark.parametrize("axis", AXES)
def test_an_axis_changes_one_thing_alone(axis):
    base = SETTINGS.disturbance
    changed = disturbed(SETTINGS, axis, SETTINGS.values(axis)[6], 1.0)
    different = [name for name in vars(base) if getattr(base, name) != getattr(changed, name)]
    of = {"motor_strength": "motor_gain", "sensor_noise": "sensing"}
    assert different == ["terrain" if axis in TERRAINS else of.get(axis, axis)]


def test_the_page_has_the_levels():
    page = (ROOT / "docs" / "how-to" / "gauge.md").read_text()
    for axis in AXES:
        first, fifth, last = (words(axis, SETTINGS.values(axis)[k]) for k in (0, 4, 9))
        assert re.search(rf"^\| `{axis}` \| [^|]+ \| {first} \| {fifth} \| {last} \|$", page, re.M)


def test_a_robot_passes_if_it_stays_up_and_covers_half_the_way():
    """Of two blocks: one that stands still, one on its way; one that fell far ahead, one short."""
    protocol = replace(SETTINGS, robots=2, duration=10.0, distance=0.5)
    covered = np.array([0.1, 2.0, 9.0, 3.9])
    command = np.zeros((3, 4, 3))
    command[:, :2, 0], command[:, 2:, 0] = 0.4, 0.8
    recording = SimpleNamespace(
        survived=np.array([True, True, False, True]),
        position=np.stack([np.stack([covered, 0 * covered], axis=1)] * 3),
        command=command,
    )
    counts = count_passes(recording, protocol)
    np.testing.assert_array_equal(counts["survived"], [2, 1])
    np.testing.assert_array_equal(counts["passed"], [1, 0])
    np.testing.assert_allclose(counts["mean_velocity"], [0.105, 0.39])


def test_sensors_on_board_err_more_and_controllers_without_them_stay():
    whole = config("env.sensing=onboard")
    section = {"env": to_dict(whole.env)}
    noisier = with_noisier_sensors(section, 3.0)["env"]["onboard"]
    before = section["env"]["onboard"]
    assert noisier["estimator"] == before["estimator"]
    assert noisier["sensors"]["torque"] == 3 * before["sensors"]["torque"]
    plain = {"plant": to_dict(config().env.plant)}
    assert with_noisier_sensors(plain, 3.0) == plain


def run(
    folder, out, axis: str, values: list[float], directions=(None,), source="walking"
) -> pd.DataFrame:
    whole = config("experiment=test")
    gauged = to_dict(whole.gauge)
    protocol = {item.name: gauged[item.name] for item in fields(GaugeProtocol)}
    protocol |= {"speeds": [0.2, 0.4], "trials": 2, "robots": 3, "duration": 0.3, "distance": 0.0}
    protocol["disturbance"]["push"] |= {"interval": 0.1, "duration": 0.02}
    section = {"controller": "policy", "robot": to_dict(whole.robot), "env": to_dict(whole.env)}
    section |= {"axis": axis, "values": values, "directions": [*directions], "protocol": protocol}
    out.mkdir()
    gauge.run(json.loads(json.dumps(section)), {source: [folder]}, out, Job(out / "work"))
    return pd.read_csv(out / gauge.CSV)


def test_levels_have_all_speeds_seeds_and_directions_up_to_one_that_nobody_passes(tmp_path):
    table = run(exported(), tmp_path / "out", "push", [0.01, 500.0, 600.0], (0.0, np.pi))
    assert len(table) == 3 * 2 * 2 * 2
    assert set(table["robots"]) == {3}
    assert list(table["seed"].unique()) == [1000, 1001]
    counts = table.groupby("level")[["survived", "passed"]].sum(min_count=1)
    assert 0 < counts.loc[1, "passed"] <= counts.loc[1, "survived"]
    assert counts.loc[2, "survived"] == 0
    assert counts.loc[3].isna().all()
    assert table[table["level"] > 1]["mean_velocity"].isna().all()


def test_an_export_is_gauged_as_the_policy_that_it_is_of(tmp_path):
    tables = [
        run(exported(), tmp_path / name, "tiles", [2.0], source=name)
        for name in ("walking", "policy")
    ]
    pd.testing.assert_frame_equal(*tables, atol=1e-5)
