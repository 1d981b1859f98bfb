"""The rooted robot on many rows at once; its M and h are compared in ``tests/numerics``."""

import casadi as ca
import numpy as np
import pytest

from slider.gait.outputs import ANKLE, LEG, driven_signs, stance_first
from slider.hzd.model import RootedModel
from slider.robot import names
from tests.gait.gaits import config
from tests.robot.lopsided import turned

MODEL = RootedModel(config().robot)
DRIVEN, SIGNS = np.array(names.GAIT_JOINTS), driven_signs(MODEL.geometry)
NUM = 11


def state(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return 0.2 * rng.standard_normal(NUM), rng.standard_normal(NUM)


def test_rows_of_roll_and_ankle_are_those_of_the_whole_dynamics():
    q, v = (np.stack(each) for each in zip(*(state(seed) for seed in range(4)), strict=True))
    rows, own, slope, bend = MODEL.constrained(q, v)
    kept, size = [0, 1 + ANKLE], 1e-6
    for k in range(4):
        mass, bias = (value.full() for value in MODEL.symbols.dynamics(q[k], v[k]))
        np.testing.assert_allclose(rows[k], mass[kept], atol=1e-12)
        np.testing.assert_allclose(own[k], bias[kept, 0], atol=1e-10)
    ahead, behind = (MODEL.measure(q + sign * size * v, v) for sign in (1, -1))
    np.testing.assert_allclose(
        (slope * v).sum(axis=1), (ahead.hip - behind.hip) / 2 / size, atol=1e-7
    )
    np.testing.assert_allclose(bend, (ahead.hip_rate - behind.hip_rate) / 2 / size, atol=1e-6)


@pytest.mark.parametrize("robot", [config().robot, turned(True)], ids=["slider", "turned"])
def test_a_pitched_foot_is_laid_flat_by_its_ankle(robot):
    (q, v), model = state(3), RootedModel(robot)
    landed, rooted = model.impact_map(q[None], v[None]), model.symbols
    assert abs(landed.pitch[0]) > 0.01
    joints = q.copy()
    joints[1 + LEG + ANKLE] += landed.pitch[0]
    foot = ca.Function("foot", [rooted.q], [rooted.poses(rooted.q)["swing_foot"].rotation])
    assert float(foot(joints)[2, 0]) == pytest.approx(0.0, abs=1e-12)
    signs = driven_signs(robot.geometry)
    expected = stance_first(joints[None, 1:], np.array([True]), signs)[0]
    np.testing.assert_allclose(landed.q[0, 1:], expected, atol=1e-12)


def test_a_displaced_foot_keeps_its_height_pitch_and_yaw():
    q = state(5)[0][None]
    matrix, size = MODEL.placement(q)[0], 1e-5
    assert not matrix[:5].any()
    rooted = MODEL.symbols
    foot = rooted.poses(rooted.q)["swing_foot"]
    sole = rooted.tree.point(foot, rooted.tree.sole)[0]
    place = ca.Function("foot", [rooted.q], [ca.vertcat(sole, foot.rotation[1:, 0])])
    for k in range(2):
        ahead, behind = (
            place(q[0] + np.r_[0.0, sign * size * matrix[:, k]]).full()[:, 0] for sign in (1, -1)
        )
        np.testing.assert_allclose((ahead - behind) / (2 * size), np.eye(5)[k], atol=1e-7)
