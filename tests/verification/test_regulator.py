"""The level leg against MuJoCo's kinematics."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from slider.robot import names
from slider.robot.mjcf import SimulationOptions, build_model
from slider.verification.regulator import level_leg
from tests.robot.lopsided import lopsided
from tests.verification.sample import config


@pytest.mark.parametrize("robot", [config().robot, lopsided()], ids=["slider", "lopsided"])
@pytest.mark.parametrize("side", names.SIDES)
def test_the_sole_is_where_it_should_be_and_its_line_along_the_heading(side, robot):
    model = build_model(robot, SimulationOptions())
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    sign = 1.0 if side == "left" else -1.0
    for _ in range(20):
        rotation = Rotation.from_euler("xyz", rng.normal(size=3) * 0.15)
        position = np.array([0.0, 0.0, 0.7]) + rng.normal(size=3) * 0.03
        sole = np.array([0.0, sign * 0.1, 0.0]) + rng.normal(size=3) * 0.05
        heading = Rotation.from_euler("zy", rng.normal(size=2) * 0.1).as_matrix()[:, 0]
        joints = level_leg(robot.geometry, side, (position, rotation.as_matrix()), sole, heading)
        data.qpos[:7] = [*position, *rotation.as_quat(scalar_first=True)]
        start = 7 + names.SIDES.index(side) * len(names.LEG_JOINTS)
        data.qpos[start : start + 5] = joints
        mujoco.mj_kinematics(model, data)
        foot = data.site(names.sole(side))
        np.testing.assert_allclose(foot.xpos, sole, atol=1e-12)
        np.testing.assert_allclose(foot.xmat.reshape(3, 3)[:, 0], heading, atol=1e-12)
