"""Parts of a step by itself: its gait, its foothold and its end."""

from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest

from slider.config.control import HzdControlConfig
from slider.control.hzd.gaits import GaitTables
from slider.control.hzd.motion import hip, section
from slider.control.hzd.steps import HzdSteps
from slider.control.whole_body.memory import LEFT, OFF, RIGHT, WALK, Memory
from slider.control.whole_body.nominal import Dynamics
from slider.env.starts import at_rest
from slider.evaluation.gait_walks import first_samples
from slider.gait.outputs import ANKLE
from slider.hzd.gains import FootPlacement
from slider.library.reader import STORE, GaitLibrary
from tests.control.hzd.test_controller import STILL, controlled, gaits
from tests.env.synthetic import config, robot_config
from tests.hzd.sample import CLOCK, COMMANDS, HIP, folder, library, placement_folder, walks

COUNT = 2
ROBOTS = np.arange(COUNT)
TICK = 0.005  # [s]
TIME = 0  # kind of gains


def control() -> HzdControlConfig:
    found = config().control["hzd"]
    assert isinstance(found, HzdControlConfig)
    return found


def walking(command: tuple[float, float, float]) -> tuple[HzdSteps, Memory, Dynamics]:
    """In the first step, at rest on the left foot, long after the change of the command."""
    controller, physics = controlled(COUNT)
    start = at_rest(robot_config(), STILL, np.random.default_rng(0), COUNT)
    physics.reset(ROBOTS, *start)
    state = physics.read()
    memory = Memory.on_both_feet(np.tile(command, (COUNT, 1)), state.yaw)
    memory.mode[:], memory.walked[:] = WALK, 10.0
    memory.old[:] = command[:2]
    steps = controller._stepping
    assert isinstance(steps, HzdSteps)
    steps.reset(COUNT)
    dynamics = controller._model.evaluate(state.qpos, state.qvel)
    steps.begin(memory, ROBOTS, dynamics, np.full(COUNT, LEFT))
    return steps, memory, dynamics


def test_a_contact_ends_a_step_that_is_not_too_early_for_it():
    steps, memory, _ = walking((0.2, 0.0, 0.0))
    early, none, both = control().step.early, np.zeros(COUNT, bool), np.ones(COUNT, bool)
    memory.elapsed[:] = early * memory.duration
    steps._walk.phase[:] = early - 0.01, early + 0.01
    assert steps.end(memory, ROBOTS, both).tolist() == [False, True]
    assert not steps.end(memory, ROBOTS, none).any()
    memory.elapsed[:] = 0.0  # the contact of the step before
    assert not steps.end(memory, ROBOTS, both).any()


def test_a_step_without_a_contact_ends_late_or_where_its_phase_is_stuck():
    steps, memory, _ = walking((0.2, 0.0, 0.0))
    none, duration = np.zeros(COUNT, bool), memory.duration[0]
    late = 1.0 + control().step.late / duration
    steps._walk.phase[:] = late - 0.01, late + 0.01
    assert steps.end(memory, ROBOTS, none).tolist() == [False, True]
    steps._walk.phase[:] = 0.3
    memory.elapsed[:] = 1.99 * duration, 2.01 * duration
    assert steps.end(memory, ROBOTS, none).tolist() == [False, True]


@pytest.mark.parametrize(
    ("last", "wanted", "bound"),
    [(0.4, 1.2, "faster"), (0.8, 0.0, "slower"), (-0.2, 0.6, "slower"), (0.4, 0.5, None)],
)
def test_the_next_gait_is_not_far_from_the_last_step(last, wanted, bound):
    steps, memory, _ = walking((wanted, 0.0, 0.0))
    memory.steps[:] = 5
    memory.starts[:] = [[0.0, 0.0, 1.0], [0.4 * last, 0.0, 1.4]]
    change = control().change
    most = {None: 1.0, "faster": change.faster, "slower": change.slower}[bound]
    expected = last + np.clip(wanted - last, -most, most)
    wanted = np.array([[wanted, 0.0]] * COUNT)
    found = steps._reachable(memory, ROBOTS, wanted)
    np.testing.assert_allclose(found, [[expected, 0.0]] * COUNT)


def test_the_last_step_of_a_turn_counts_along_its_middle():
    steps, memory, _ = walking((0.6, 0.0, 0.3))
    memory.steps[:], memory.heading[:] = 5, 0.3 * 0.4
    middle = 0.3 * 0.2
    way = 0.4 * 0.6 * np.array([np.cos(middle), np.sin(middle)])
    memory.starts[:] = [[0.0, 0.0, 1.0], [*way, 1.4]]
    memory.old[:], bound = 0.0, replace(control().change, faster=1e-9, slower=1e-9)
    steps._config = replace(control(), change=bound)
    wanted = np.array([[0.6, 0.0]] * COUNT)
    np.testing.assert_allclose(steps._reachable(memory, ROBOTS, wanted), wanted, atol=1e-8)


def placed(phase: float, error: float, gain: float = -1.0) -> np.ndarray:
    """Leftward displacement [m] after a tick; K(s) is a gain of the lateral place alone."""
    steps, memory, dynamics = walking((0.2, 0.0, 0.0))
    walk = steps._walk
    gains = np.zeros_like(walk.steps.gains)
    gains[:, TIME, :, 1, 0] = gain
    orbit = np.tile(section(dynamics, memory.stance)[:, None], (1, gains.shape[2], 1))
    orbit[:, :, 0] -= error
    walk.steps = replace(walk.steps, gains=gains, orbit=orbit)
    walk.phase[:] = phase
    steps._place(walk, memory, ROBOTS, dynamics)
    return walk.constraints.displacement[:, 1]


def test_the_foothold_follows_with_its_time_constant_up_to_the_lock():
    share = TICK / control().settling
    np.testing.assert_allclose(placed(0.5, 0.01), share * 0.01)
    np.testing.assert_allclose(placed(control().lock - 1e-3, 0.01), share * 0.01)
    assert not placed(control().lock, 0.01).any()


def test_the_foothold_stays_within_reach():
    reach = config().hzd.feedback.reach
    np.testing.assert_allclose(placed(0.5, 3.0), TICK / control().settling * reach)
    np.testing.assert_allclose(placed(0.5, -3.0), -TICK / control().settling * reach)


def test_no_gait_is_faster_than_the_fastest():
    steps, memory, _ = walking((3.0, 0.0, 0.0))
    fastest = control().fastest
    found = steps._reachable(memory, ROBOTS, np.array([[3.0, 0.0]] * COUNT))
    np.testing.assert_allclose(found[:, 0], fastest)


def test_the_integral_action_waits_while_the_gait_is_bounded():
    for reachable, moved in ((0.9, True), (0.1, False)):
        steps, memory, dynamics = walking((0.4, 0.0, 0.0))
        memory.steps[:], memory.walked[:] = 5, 20.0
        memory.starts[:] = [[-0.2, 0.0, 19.2], [0.0, 0.0, 19.6]]
        change = replace(control().change, faster=reachable, slower=reachable)
        steps._config = replace(control(), change=change)
        steps._next_velocity(memory, ROBOTS, dynamics)
        assert memory.correction[:, 0].astype(bool).all() == moved


@pytest.mark.parametrize(
    ("phase", "rate", "expected"),
    [(0.0, 1.0, True), (0.5, 1.0, False), (-0.4, 1.0, False), (0.0, 0.4, False), (0.0, 1.7, False)],
)
def test_a_step_goes_by_the_hip_where_it_begins_as_the_gait_does(phase, rate, expected):
    steps, _, _ = walking((0.6, 0.0, 0.0))
    walk = steps._walk
    place, slope, _ = walk.steps.hip.at(np.full(COUNT, phase))
    speed = rate * slope[:, 0] / walk.steps.duration
    assert steps._tells_phase(walk, place[:, 0], speed).tolist() == [expected] * COUNT


def test_by_the_hip_nine_outputs_are_met_whatever_the_ankle_does():
    """Accelerations that fulfil nine rows have ÿ + kd ẏ + kp y = 0 with the s̈ that they give."""
    steps, memory, dynamics = walking((0.6, 0.0, 0.0))
    walk = steps._walk
    walk.by_hip[:], walk.phase[:], walk.rate[:] = True, 0.4, 2.0
    motion = steps._motion(walk, memory, ROBOTS, dynamics)
    rows, wanted, _ = steps._outputs(walk, motion)
    kept = [k for k in range(10) if k != ANKLE]
    for robot in range(COUNT):
        solution = np.linalg.lstsq(rows[robot, kept], wanted[robot, kept], rcond=None)[0]
        advance, bend = (order[robot, 0] for order in walk.steps.hip.at(walk.phase)[1:])
        ahead = np.array([np.cos(walk.line[robot]), np.sin(walk.line[robot])])
        turn = (ahead @ solution[:2] - bend * 4.0) / advance
        value, slope, curve = (order[robot] for order in walk.constraints.desired(walk.phase))
        y, y_rate = motion.x[robot] - value, motion.rate[robot] - 2.0 * slope
        bending = motion.jacobian[robot] @ solution - curve * 4.0 - slope * turn
        error = bending + steps._constraints.kd * y_rate + steps._constraints.kp * y
        np.testing.assert_allclose((steps._matrix @ error)[kept], 0.0, atol=1e-6)


TURN = (0.6, 0.0, 0.3)


@cache
def turning() -> GaitLibrary:
    return GaitLibrary.load(folder((TURN,)) / STORE)


def feedback(commands: np.ndarray) -> FootPlacement:
    """That of other gaits, for a test without a step."""
    whole = FootPlacement.load(placement_folder())
    rows = {f.name: getattr(whole, f.name)[:1] for f in fields(FootPlacement) if f.name != "phases"}
    return replace(whole, **rows | {"commands": commands})


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_a_gait_that_turns_is_on_its_own_constraints(side):
    """Samples of the gait, whose course has the commanded heading, have outputs of zero."""
    library = turning()
    half = library.samples.shape[1] // 2
    rows = slice(side * half, (side + 1) * half)
    enforced = replace(gaits(), gaits=GaitTables.of(library, feedback(library.commands)))
    controller, _ = controlled(half, enforced)
    steps, everyone = controller._stepping, np.arange(half)
    assert isinstance(steps, HzdSteps)
    base, joints = library.base[0, rows], library.samples[0, rows]
    qpos = np.concatenate([base[:, :7], joints[:, :12]], axis=1)
    qvel = np.concatenate([base[:, 7:], joints[:, 12:24]], axis=1)
    time, duration = library.arrays["time"][0, rows], library.step_time[0, side]
    memory = Memory.on_both_feet(np.tile(TURN, (half, 1)), TURN[2] * (time - duration / 2))
    memory.mode[:], memory.stance[:] = WALK, side
    dynamics = controller._model.evaluate(qpos, qvel)
    walk = steps._new(memory.command, memory.stance)
    walk.phase = (time - side * duration) / duration
    motion = steps._motion(walk, memory, everyone, dynamics)
    value, slope, _ = walk.constraints.desired(walk.phase)
    np.testing.assert_allclose(motion.x, value, atol=1e-6)
    np.testing.assert_allclose(motion.rate, slope / duration, atol=1e-4)


def test_the_hip_is_measured_along_the_line_on_which_the_gait_has_the_foot():
    steps, memory, dynamics = walking((0.2, 0.0, 0.0))
    np.testing.assert_array_equal(steps._walk.line, memory.heading)
    walk = steps._walk
    walk.line[:] = 0.0, np.pi / 2
    place, speed = hip(dynamics, np.full(COUNT, RIGHT), walk.line)
    sole = dynamics.foot_positions[:, RIGHT, :2]
    along = (dynamics.base_position[:, :2] - sole)[ROBOTS, ROBOTS]
    np.testing.assert_allclose(place, along)
    np.testing.assert_allclose(speed, dynamics.qvel[ROBOTS, ROBOTS])


@pytest.mark.parametrize(("side", "sign"), [(LEFT, 1.0), (RIGHT, -1.0)])
def test_the_foot_is_half_a_turn_ahead_of_the_heading_at_touchdown(side, sign):
    library = turning()
    enforced = replace(gaits(), gaits=GaitTables.of(library, feedback(library.commands)))
    controller, physics = controlled(1, enforced)
    steps, turn = controller._stepping, TURN[2] * library.step_time[0, side]
    assert isinstance(steps, HzdSteps)
    physics.reset(np.zeros(1, int), *at_rest(robot_config(), STILL, np.random.default_rng(0), 1))
    state = physics.read()
    memory = Memory.on_both_feet(np.array([TURN]), np.array([0.7]))
    memory.mode[:] = WALK
    steps.reset(1)
    dynamics = controller._model.evaluate(state.qpos, state.qvel)
    steps.begin(memory, np.zeros(1, int), dynamics, np.full(1, side))
    assert steps._walk.steps.turn[0] == pytest.approx(sign * turn)
    assert steps._walk.line[0] == pytest.approx(0.7 + turn / 2)


def test_a_straight_gait_turns_about_the_middle_of_its_step():
    steps, memory, _ = walking((0.4, 0.0, 0.2))
    assert not library().commands[:, 2].any()
    turn = 0.2 * memory.duration
    np.testing.assert_allclose(steps._walk.steps.turn, turn)
    np.testing.assert_allclose(steps._walk.line, memory.heading + turn / 2)


def test_the_yaw_rate_of_a_walk_grows_to_another_command():
    steps, memory, dynamics = walking((0.0, 0.0, 0.3))
    most = control().yaw_acceleration * TICK
    commands = np.array([(0.0, 0.0, -0.3), (0.0, 0.0, 0.0)])
    steps.command(memory, commands)
    np.testing.assert_allclose(memory.command[:, 2], [0.3, 0.0])  # to stand: at once
    rates = []
    for _ in range(round(0.6 / most) + 5):
        steps.torques(memory, ROBOTS, dynamics)
        rates.append(memory.command[0, 2])
    assert commands[0, 2] == rates[-1] == -0.3
    assert np.abs(np.diff(rates)).max() <= most * (1 + 1e-9)
    assert all(rates)


@pytest.mark.parametrize("gait", [CLOCK, HIP])
def test_a_perturbed_step_ends_where_the_return_map_says(gait):
    """MuJoCo's robot, feedback and motors against A − B K of the rooted model."""
    push = np.array([0.05, -0.05])  # lateral velocity at the start of a step [m/s]
    controller, physics = controlled(COUNT)
    start = [np.repeat(each[gait : gait + 1], COUNT, 0) for each in first_samples(library())]
    start[1][:, 1] += push
    physics.reset(ROBOTS, *start)
    state = physics.read()
    controller.start_on_gait(state, np.tile(COMMANDS[gait], (COUNT, 1)), np.zeros(COUNT))
    steps, memory = controller._stepping, controller.memory
    assert isinstance(steps, HzdSteps)
    seen = np.zeros((COUNT, 4))
    for _ in range(120):
        before = memory.steps.copy()
        physics.step(controller.control(state))
        state = physics.read()
        landed = memory.steps > before
        dynamics = controller._model.evaluate(state.qpos, state.qvel)
        seen[landed] = section(dynamics, memory.stance)[landed]
        if (memory.steps == 2).all():
            break
        controller.memory.mode[memory.steps == 2] = OFF
    found = (seen[0] - seen[1]) / (push[0] - push[1])
    expected = walks()[gait].closed[0][:2, 1]
    np.testing.assert_allclose(found[:2], expected, rtol=0.15)
