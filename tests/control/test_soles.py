"""The baseline walks on feet with soles, by the motors of the ankles' rolls."""

import mujoco
import numpy as np

from slider.control.model_based import build_controller, build_plant
from slider.env.rollout import roll_out
from slider.env.starts import at_rest
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.names import LAST_JOINTS, SIDES, foot
from tests.control.walking import STILL
from tests.env.synthetic import config, robot_config
from tests.robot.soled import with_soles


def test_walks_on_soles_that_stay_level():
    robot, whole, command = with_soles(robot_config(), 0.05, 0.04), config(), [[0.4, 0.0, 0.0]]
    control = whole.control["mpc_wbc_tuned"]
    physics = build_plant(robot, whole.env.plant, control, 1)
    controller = build_controller(robot, control, whole.env.physics, 1, None)
    start = at_rest(robot, STILL, np.random.default_rng(7), 1)
    recording = roll_out(controller, physics, whole.env, start, np.array(command), 4.0)
    assert recording.survived.all()
    np.testing.assert_allclose(recording.velocity[-80:, 0, 0].mean(), 0.4, atol=0.05)
    state = physics.read()
    assert np.abs(state.joint_positions[0, list(LAST_JOINTS)]).max() > 0.002, "the ankles roll"
    data = mujoco.MjData(build_model(robot, SimulationOptions()))
    data.qpos[3:] = np.concatenate([state.quaternion[0], state.joint_positions[0]])
    mujoco.mj_kinematics(data.model, data)
    tilts = [data.body(foot(side)).xmat[7] for side in SIDES]
    np.testing.assert_allclose(tilts, 0.0, atol=0.03)
