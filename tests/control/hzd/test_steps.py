"""Steps by virtual constraints: their gait, their end, and the return map in MuJoCo."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from slider.config.control import HzdControlConfig
from slider.control.hzd.motion import com_state
from slider.control.hzd.steps import HzdSteps
from slider.control.whole_body.controller import PlantModel
from slider.control.whole_body.memory import LEFT, OFF, RIGHT, WALK, Memory
from slider.control.whole_body.model import Dynamics
from slider.evaluation.gait_walks import first_samples
from slider.hzd.regulator import regulate
from slider.robot.mjcf import nominal_qpos
from tests.control.hzd.test_controller import controlled, gaits, integrating
from tests.control.walking import nominal
from tests.env.synthetic import config, robot_config
from tests.hzd.sample import CLOCK, HIP, VELOCITIES, library, settings, zero

COUNT = 2
ROBOTS = np.arange(COUNT)
TICK = 0.005  # [s]
CONTROL = config().control["hzd"]


def standing() -> Dynamics:
    """At rest in the nominal pose."""
    qpos = np.tile(nominal_qpos(robot_config()), (COUNT, 1))
    return nominal().evaluate(qpos, np.zeros((COUNT, 18)))


def walking(
    velocity: tuple[float, float, float], settings: HzdControlConfig | None = None
) -> tuple[HzdSteps, Memory, list[np.ndarray]]:
    """Long after the commanded velocity changed, in the first step of a walk on the left foot.

    The list gets the velocities at which gaits are read.
    """
    settings, recorded, read = settings or CONTROL, copy(gaits()), []
    recorded.at = lambda at, stance: read.append(at.copy()) or gaits().at(at, stance)
    plant = PlantModel(robot_config(), settings, settings.descent, TICK)
    steps = HzdSteps(robot_config(), settings, recorded, plant)
    memory = Memory.on_both_feet(np.tile(velocity, (COUNT, 1)), np.zeros(COUNT))
    memory.mode[:], memory.walked[:] = WALK, 10.0
    memory.previous[:] = velocity[:2]
    steps.reset(COUNT)
    steps.begin(memory, ROBOTS, standing(), np.full(COUNT, LEFT))
    return steps, memory, read


@pytest.mark.parametrize("contact", [True, False])
def test_a_step_ends_at_a_contact_that_is_not_early_or_late_without_one(contact):
    steps, memory, _ = walking((0.2, 0.0, 0.0))
    duration, step = memory.duration[0], CONTROL.step
    expected = step.early * duration if contact else duration + step.late
    flags, dynamics, ticks = np.full(COUNT, contact), standing(), 0
    while not steps.end(memory, ROBOTS, flags).any():
        steps.torques(memory, ROBOTS, dynamics)
        ticks += 1
    assert ticks * TICK == pytest.approx(expected, abs=1.01 * TICK)
    memory.elapsed[:] = 0.0  # the contact of the step before
    assert steps.end(memory, ROBOTS, flags).any() == (not contact)


def test_a_step_ends_where_its_phase_is_stuck():
    steps, memory, _ = walking((0.2, 0.0, 0.0))
    memory.elapsed[:] = np.array([0.99, 1.01]) * memory.duration[0] / CONTROL.hip_rate.lower
    assert steps.end(memory, ROBOTS, np.zeros(COUNT, bool)).tolist() == [False, True]


def next_velocity(planned: tuple[float, float, float], last: float, turned: float) -> np.ndarray:
    """Velocity (3,) of the gait of a step after one at ``last`` [m/s] along its middle."""
    steps, memory, read = walking(planned)
    memory.steps[:], memory.heading[:], memory.walked[:] = 5, turned, 20.0
    way = 0.4 * last * np.array([np.cos(turned / 2), np.sin(turned / 2)])
    dynamics = standing()
    now = dynamics.com[0, :2]
    memory.starts[:] = [[0.0, 0.0, 19.2], [*(now - way), 19.6]]
    memory.changed[:] = 20.0  # no integral action yet
    memory.previous[:] = planned[:2]
    steps.begin(memory, ROBOTS, dynamics, np.full(COUNT, RIGHT))
    return read[-1][0]


@pytest.mark.parametrize(
    ("last", "planned", "bound"),
    [
        (0.4, 1.2, "faster"),
        (0.8, 0.0, "slower"),
        (-0.2, 0.6, "slower"),
        (0.4, 0.5, None),
        (3.0, 3.0, None),
    ],
)
def test_the_next_gait_is_not_far_from_the_last_step(last, planned, bound):
    change = CONTROL.change
    most = {None: 1.0, "faster": change.faster, "slower": change.slower}[bound]
    expected = min(last + np.clip(planned - last, -most, most), CONTROL.fastest)
    for yaw_rate in (0.0, 0.3):
        velocity = next_velocity((planned, 0.0, yaw_rate), last, 0.4 * yaw_rate)
        np.testing.assert_allclose(velocity[:2], [expected, 0.0], atol=1e-9)


@pytest.mark.parametrize(("reachable", "moves"), [(0.9, True), (0.1, False)])
def test_the_integral_action_waits_while_the_gait_is_bounded(reachable, moves):
    change = replace(CONTROL.change, faster=reachable, slower=reachable)
    steps, memory, _ = walking((0.4, 0.0, 0.0), replace(integrating(), change=change))
    memory.steps[:], memory.walked[:] = 5, 20.0
    memory.starts[:] = [[-0.2, 0.0, 19.2], [0.0, 0.0, 19.6]]
    steps.begin(memory, ROBOTS, standing(), np.full(COUNT, RIGHT))
    assert memory.correction[:, 0].astype(bool).all() == moves


@pytest.mark.parametrize(("side", "sign"), [(LEFT, 1.0), (RIGHT, -1.0)])
def test_a_straight_gait_turns_with_the_commanded_yaw_rate(side, sign):
    """Reflected in right stance."""
    assert not library().velocities[:, 2].any()
    steps = gaits().at(np.array([[0.4, 0.0, 0.2]]), np.array([side]))
    np.testing.assert_allclose(steps.turn, sign * 0.2 * steps.duration)


def test_the_yaw_rate_of_a_walk_grows_to_another_command():
    steps, memory, _ = walking((0.0, 0.0, 0.3))
    most, dynamics = CONTROL.yaw_acceleration * TICK, standing()
    velocities = np.array([(0.0, 0.0, -0.3), (0.0, 0.0, 0.0)])
    steps.set_velocity(memory, velocities)
    np.testing.assert_allclose(memory.velocity[:, 2], [0.3, 0.0])  # to stand: at once
    rates = []
    for _ in range(round(0.6 / most) + 5):
        steps.torques(memory, ROBOTS, dynamics)
        rates.append(memory.velocity[0, 2])
    assert velocities[0, 2] == rates[-1] == -0.3
    assert np.abs(np.diff(rates)).max() <= most * (1 + 1e-9)
    assert all(rates)


@pytest.mark.parametrize("gait", [CLOCK, HIP])
def test_a_perturbed_step_ends_as_in_the_return_map(gait):
    """MuJoCo's robot, feedback and motors against A − B K of the rooted model."""
    push = np.array([0.05, -0.05])  # lateral velocity at the start of a step [m/s]
    controller, physics = controlled(COUNT)
    start = [np.repeat(each[gait : gait + 1], COUNT, 0) for each in first_samples(library())]
    start[1][:, 1] += push
    physics.reset(ROBOTS, *start)
    state = physics.read()
    controller.start_on_gait(state, np.tile(VELOCITIES[gait], (COUNT, 1)), np.zeros(COUNT))
    memory, ends = controller.memory, np.zeros((COUNT, 4))
    for _ in range(120):
        before = memory.steps.copy()
        physics.step(controller.control(state))
        state = physics.read()
        landed = memory.steps > before
        dynamics = nominal().evaluate(state.qpos, state.qvel)
        ends[landed] = com_state(dynamics, memory.stance)[landed]
        if (memory.steps == 2).all():
            break
        memory.mode[memory.steps == 2] = OFF
    derivative = (ends[0] - ends[1]) / (push[0] - push[1])
    walk, gains = zero(gait), regulate(zero(gait), 0, settings().feedback).gains
    expected = (walk.maps[0, 0] - walk.inputs[0, 0] @ gains[0])[:2, 1]
    np.testing.assert_allclose(derivative[:2], expected, rtol=0.15)
