"""The baseline walks in the simulator: each setting, sideways, turning, perturbed."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from slider.control.model_based import build_controller, build_plant
from slider.control.mpc import advance_swing, mpc_controller, swing_at_rest
from slider.control.whole_body.memory import OFF, STAND, WALK
from slider.control.whole_body.references import ReferenceVelocity
from slider.env.disturbance import Disturbance
from slider.env.metrics import CONTACT_FORCE
from slider.env.rollout import roll_out
from slider.env.starts import at_rest
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.names import LAST_JOINTS, SIDES, foot
from tests.config.composed import CONF, composed
from tests.control.walking import COUNT, STILL, walk
from tests.env.synthetic import config, disturbance, make_arrays, robot_config
from tests.robot.lopsided import with_soles

TUNED = "mpc_wbc_tuned"
SETTLED = 6.0  # the integral action needs some strides [s]


def test_walks_on_slopes_that_it_receives():
    """One robot each: up, down and across."""
    text = "kinds: [slope_up, slope_down, slope_across], level: {lower: 4.8, upper: 4.8}"
    drawn = Disturbance(disturbance(f"terrain={{{text}}}"), (1,))
    segment = SETTLED, (0.6, 0.0, 0.0)
    recording, controller = walk(TUNED, segment, noise=True, count=3, drawn=drawn)
    assert recording.survived.all()
    assert (controller.memory.mode == WALK).all()
    expected = (SETTLED - 0.3) / config().control[TUNED].step.time
    np.testing.assert_allclose(controller.memory.steps, expected, atol=3)
    mean = recording.velocity[-90:].mean(axis=0)
    np.testing.assert_allclose(mean, [[0.6, 0.0]] * 3, atol=0.06)


def test_walks_on_soles_that_stay_level():
    robot, whole, command = with_soles(robot_config(), 0.05, 0.04), config(), [[0.4, 0.0, 0.0]]
    control = whole.control[TUNED]
    physics = build_plant(robot, whole.env.plant, control, 1)
    controller = build_controller(robot, control, whole.env.physics, 1, None)
    start = at_rest(robot, STILL, np.random.default_rng(7), 1)
    recording = roll_out(controller, physics, whole.env, start, np.array(command), 4.0)
    assert recording.survived.all()
    np.testing.assert_allclose(recording.velocity[-80:, 0].mean(axis=0), [0.4, 0.0], atol=0.05)
    state = physics.read()
    assert np.abs(state.joint_positions[0, list(LAST_JOINTS)]).max() > 0.002, "the ankles roll"
    data = mujoco.MjData(build_model(robot, SimulationOptions()))
    data.qpos[3:] = np.concatenate([state.quaternion[0], state.joint_positions[0]])
    mujoco.mj_kinematics(data.model, data)
    tilts = [data.body(foot(side)).xmat[7] for side in SIDES]
    np.testing.assert_allclose(tilts, 0.0, atol=0.03)


@pytest.mark.parametrize(
    ("name", "count", "seconds"), [("unitree_h1.yaml", 2, 3.0), ("unitree_h1_2", 12, 0.2)]
)
def test_the_general_settings_are_for_robots_with_knees_and_heavy_ones_on_soles(
    name, count, seconds
):
    """DAQP alone finds QPs of four of the twelve starts infeasible."""
    whole = composed(f"robot={CONF.parent}/docs/examples/robots/{name}")
    control = whole.control["mpc_wbc_general"]
    physics = build_plant(whole.robot, whole.env.plant, control, count)
    controller = build_controller(whole.robot, control, whole.env.physics, count, None)
    start = at_rest(whole.robot, whole.evaluation.start, np.random.default_rng(3000), count)
    command = np.tile([0.4, 0.0, 0.0], (count, 1))
    recording = roll_out(controller, physics, whole.env, start, command, seconds)
    assert (controller.memory.mode != OFF).all()
    if seconds > 2.0:
        assert recording.survived.all()
        speed = recording.velocity[-50:, :, 0].mean(axis=0)
        np.testing.assert_allclose(speed, 0.4, atol=0.06)


def test_a_robot_does_not_depend_on_the_others():
    """The second of two robots with starts of their own, alone."""
    whole, two = config(), walk(TUNED, (1.0, (0.6, 0.0, 0.0)), noise=True)[0]
    physics = build_plant(robot_config(), whole.env.plant, whole.control[TUNED], 1)
    controller = mpc_controller(robot_config(), whole.control[TUNED], physics.period)
    starts = at_rest(robot_config(), whole.evaluation.start, np.random.default_rng(7), COUNT)
    start, command = tuple(values[1:] for values in starts), np.array([[0.6, 0.0, 0.0]])
    alone = roll_out(controller, physics, whole.env, start, command, 1.0)
    np.testing.assert_allclose(alone.velocity[:, 0], two.velocity[:50, 1], atol=1e-6)


def test_switches_off_where_it_has_fallen():
    control = config().control[TUNED]
    controller = mpc_controller(robot_config(), control, 0.005)
    state = make_arrays(2, foot_forces=60.0)
    controller.reset(state, np.zeros((2, 3)))
    lying = replace(state, gravity=np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]))
    torques = controller.control(lying)
    assert controller.memory.mode[1] == OFF
    assert not torques[1].any()
    assert np.abs(torques[0, [3, 9]]).min() > 20, "the other one stands"
    assert not controller.control(state)[1].any(), "off is for ever"


def test_stands_still_goes_sideways_and_turning_and_stops():
    """At 0.4 m/s with 0.1 m/s to the left, then with 0.3 rad/s; both ends on both feet."""
    still, sideways, turning = (0.0, 0.0, 0.0), (0.4, 0.1, 0.0), (0.4, 0.0, 0.3)
    segments = (1.0, still), (5.0, sideways), (3.0, turning), (2.5, still)
    recording, controller = walk(TUNED, *segments, noise=True)
    assert recording.survived.all()
    steps = np.cumsum([50, 250, 150, 125])
    contact = recording.foot_forces > CONTACT_FORCE
    assert contact[25:50].all(), "it stands before it is commanded to go"
    assert (contact[100:300].sum(axis=2) == 1).mean() > 0.9
    assert 0.3 < contact[100:300, :, 0].mean() < 0.7, "both legs carry"
    leftward = recording.velocity[steps[1] - 90 : steps[1], :, 1].mean()
    np.testing.assert_allclose(leftward, 0.1, atol=0.04)
    yaw = np.unwrap(recording.yaw, axis=0)
    turned = yaw[steps[2] - 1] - yaw[steps[1] + 50]
    np.testing.assert_allclose(turned / 1.98, 0.3, atol=0.02)
    assert (controller.memory.mode == STAND).all()
    assert contact[-50:].all(), "it stands again"
    moved = recording.position[-1] - recording.position[-50]
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), 0.0, atol=0.01)


def test_the_reference_goes_from_the_old_command_to_the_new_one():
    _, controller = walk(TUNED, (1.5, (0.6, 0.0, 0.0)), (0.1, (0.0, 0.1, 0.0)))
    memory = controller.memory
    np.testing.assert_allclose(memory.previous[:, 0], 0.6)
    since = memory.walked - memory.changed
    np.testing.assert_allclose(since, 0.1, atol=1e-9)
    settings = config().control[TUNED].velocity
    left = np.hypot(0.6, 0.1) - settings.acceleration * 0.1
    reference = ReferenceVelocity(settings, 0.005).planned(memory, np.arange(COUNT))
    found = np.linalg.norm(reference - [0.0, 0.1], axis=1)
    np.testing.assert_allclose(found, left, atol=1e-9)


SETTINGS = config().control[TUNED].swing
TIME, APEX, PERIOD, GROUND = 0.3, 0.07, 0.005, 0.002


def fly(target_at) -> np.ndarray:
    """Reference (ticks, 3, 3) of one swing and 10 ticks beyond; ``target_at`` maps time → (2,)."""
    reference, path = swing_at_rest(np.array([[-0.2, 0.1, 0.0]])), []
    for tick in range(round(TIME / PERIOD) + 10):
        reference = advance_swing(
            reference,
            np.array([target_at(tick * PERIOD)]),
            np.array([tick * PERIOD]),
            np.array([TIME]),
            np.array([GROUND]),
            np.array([APEX + GROUND]),
            SETTINGS,
            PERIOD,
        )
        path.append(reference[0])
    return np.array(path)


@pytest.mark.parametrize("moved", [(0.2, 0.12), (0.26, 0.08)])
def test_lands_on_the_foothold_in_time_and_sinks_on(moved):
    """Also on one that moves, and nothing jumps."""
    path = fly(lambda t: (0.2, 0.12) if t < 0.1 else moved)
    end = round(TIME / PERIOD) - 1
    np.testing.assert_allclose(path[end, :2, 0], moved, atol=2e-3)
    speed = np.diff(path[: end + 1, :2, 0], axis=0) / PERIOD
    assert np.abs(np.diff(speed, axis=0)).max() < 0.3  # [m/s] within a tick
    assert path[end, 2, 0] == pytest.approx(GROUND, abs=1e-3)
    assert path[:, 2, 0].max() == pytest.approx(APEX + GROUND, abs=2e-3)
    assert abs(int(path[:, 2, 0].argmax()) - end // 2) <= 3
    np.testing.assert_allclose(np.diff(path[end + 1 :, 2, 0]), -SETTINGS.search_velocity * PERIOD)
