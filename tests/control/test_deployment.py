"""The graphs do what policy and estimator of this package do, and survive bad readings."""

from dataclasses import replace

import numpy as np
import onnxruntime
import pytest
import torch

from slider.config.env import SensorsConfig
from slider.control.deployment import Step, estimator_step, policy_step
from slider.control.export import Both
from slider.control.exported import OnnxController
from slider.control.onnx_graph import save
from slider.control.policy import Policy, PolicyController
from slider.env.interface import AgentInterface
from slider.env.physics import BatchedPhysics
from slider.env.rollout import roll_out
from slider.env.starts import USUAL_NOISE, at_rest
from slider.library.lookup import GaitTable
from slider.robot.mjcf import nominal_qpos
from slider.robot.names import GRAVITY
from tests.control import policies
from tests.control.policies import make_policy
from tests.env.synthetic import config, turning_library
from tests.robot.lopsided import kneed, turned

VELOCITY = np.array([0.3, 0.05, 0.4])  # turning, between the gaits of the library
STEPS, STARTED, STOPPED = 65, 5, 45  # the command is zero before and afterwards
LONG = 500  # 10 s
COUNT = 3


def graph(step: Step, path) -> onnxruntime.InferenceSession:
    sizes = {name: len(reading.default) for name, reading in step.readings.items()}
    outputs = [*step.outputs, "next_state"]
    save(step.function, sizes | {"state": step.state_size}, outputs, {}, path)
    return onnxruntime.InferenceSession(path)


@pytest.fixture(scope="module")
def default(tmp_path_factory) -> tuple[Step, onnxruntime.InferenceSession]:
    step = policy_step(make_policy())
    return step, graph(step, tmp_path_factory.mktemp("graph") / "policy.onnx")


def both(policy: Policy, path, count: int) -> Both:
    graph(policy_step(policy), path)
    agent = AgentInterface(policy.robot, policy.env, count, policy.times, policy.reference)
    exported = OnnxController(path, policy.env.observation.height_scan)
    return Both(PolicyController(policy.network, agent), exported)


@pytest.mark.parametrize(
    ("overrides", "turning"),
    [
        ((), False),
        ((), True),
        (("env=paper",), True),
        (("env/observation=seeing",), False),
        (("env.phase.mirror=false",), True),
        (("env.phase.halt.below=5.0", "env.phase.halt.above=5.0"), True),
        (("env.action.offset=nominal",), True),
        (("env.reference.acceleration=0",), False),
    ],
)
def test_the_graph_acts_like_the_policy(tmp_path, monkeypatch, overrides, turning):
    """Robots that start and stop, in closed loop."""
    if turning:
        table = GaitTable.from_library(turning_library())
        monkeypatch.setattr(policies, "gait_table", lambda: table)
    policy = make_policy(*overrides)
    controllers = both(policy, tmp_path / "policy.onnx", COUNT)
    physics = BatchedPhysics(policy.robot, policy.env.physics, COUNT)
    start = at_rest(policy.robot, USUAL_NOISE, np.random.default_rng(0), COUNT)
    steps = STEPS if overrides or turning else LONG
    commands = np.zeros((steps, COUNT, 3))
    commands[STARTED:STOPPED] = np.array([[1.0], [-0.5], [0.0]]) * VELOCITY
    roll_out(controllers, physics, policy.env, start, commands, steps * policy.env.control_period)
    assert controllers.difference < 1e-6
    assert np.ptp(controllers.targets, axis=0).max() > 1e-3, "robots must do different things"


def test_the_graph_estimates_like_the_package(tmp_path):
    whole = config("experiment=test")
    onboard = replace(whole.env.onboard, sensors=SensorsConfig(*[0.0] * 17))
    physics = BatchedPhysics(whole.robot, whole.env.physics, COUNT, onboard=onboard)
    start = at_rest(whole.robot, USUAL_NOISE, np.random.default_rng(0), COUNT)
    physics.reset(np.arange(COUNT), *start)
    step = estimator_step(whole.robot, onboard.estimator)
    session = graph(step, tmp_path / "estimator.onnx")
    state, before = np.zeros((COUNT, step.state_size)), physics.qvel[:, :3].copy()
    targets = np.tile(nominal_qpos(whole.robot)[7:], (COUNT, 1))
    for tick in range(STEPS):
        true = physics.read()
        expected = physics.measure(true)
        elapsed = whole.env.control_period * (tick > 0)
        gained = physics.qvel[:, :3] - before + elapsed * np.array([0.0, 0.0, GRAVITY])
        before = physics.qvel[:, :3].copy()
        given = {
            "velocity_increment": np.einsum("nji,nj->ni", true.rotation, gained),
            "elapsed": np.full((COUNT, 1), elapsed),
        }
        feeds = {n: given[n] if n in given else getattr(expected, n) for n in step.readings}
        velocity, height, state = session.run(None, feeds | {"state": state})
        np.testing.assert_allclose(velocity, expected.linear_velocity, atol=1e-9)
        np.testing.assert_allclose(height[:, 0], expected.base_height, atol=1e-9)
        targets[:, 2] = 0.2 * np.sin(0.3 * tick)
        physics.step(targets)
    assert np.abs(velocity[:, 0]).max() > 0.01, "the robots must move"


def readings(step: Step, seed: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    given = {
        name: np.array([reading.default]) + 0.02 * rng.standard_normal((1, len(reading.default)))
        for name, reading in step.readings.items()
    }
    given["quaternion"] /= np.linalg.norm(given["quaternion"])
    return given


@pytest.mark.parametrize("robot", [kneed(), turned(True)], ids=["kneed", "turned"])
def test_legs_with_knees_have_the_graph_of_an_estimator(robot, tmp_path):
    step = estimator_step(robot, config("experiment=test").env.estimator)
    session = graph(step, tmp_path / "estimator.onnx")
    state, ours = np.zeros((1, step.state_size)), torch.zeros(1, step.state_size).double()
    for seed in range(3):
        given = readings(step, seed) | {"elapsed": np.full((1, 1), 0.02)}
        velocity, height, state = session.run(None, given | {"state": state})
        *expected, ours = step.function(*(torch.tensor(v) for v in given.values()), ours)
        for found, value in zip((velocity, height), expected, strict=True):
            np.testing.assert_allclose(found, value.numpy(), atol=1e-9)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e9])
@pytest.mark.parametrize(
    ("name", "index"),
    [("joint_positions", 3), ("joint_velocities", 8), ("linear_velocity", 0), ("command", 0)],
)
def test_a_bad_value_counts_as_the_one_before(default, name, index, bad):
    step, session = default
    _, state = session.run(None, readings(step, 0) | {"state": np.zeros((1, step.state_size))})
    now, held = readings(step, 1), readings(step, 1)
    now[name][0, index], held[name][0, index] = bad, readings(step, 0)[name][0, index]
    found, expected = (session.run(None, given | {"state": state}) for given in (now, held))
    for value, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(value, other)


@pytest.mark.parametrize("bad", [[np.nan, 0, 0, 0], [0, 0, 0, 0], [1, np.inf, 0, 0], [9, 0, 0, 0]])
def test_a_bad_attitude_counts_as_the_one_before_or_upright(default, bad):
    step, session = default
    fresh = np.zeros((1, step.state_size))
    now, upright = readings(step, 0), readings(step, 0)
    now["quaternion"], upright["quaternion"] = (
        np.array([bad], float),
        np.array([[1.0, 0.0, 0.0, 0.0]]),
    )
    found, expected = (session.run(None, given | {"state": fresh}) for given in (now, upright))
    np.testing.assert_array_equal(found[0], expected[0])
    assert np.isfinite(found[1]).all()


def test_a_state_of_zeros_starts_anew(default):
    step, session = default
    fresh = np.zeros((1, step.state_size))
    first, state = session.run(None, readings(step, 0) | {"state": fresh})
    for seed in range(30):
        _, state = session.run(None, readings(step, seed) | {"state": state})
    assert np.abs(session.run(None, readings(step, 0) | {"state": state})[0] - first).max() > 1e-3
    again, _ = session.run(None, readings(step, 0) | {"state": fresh})
    np.testing.assert_array_equal(again, first)


def test_yaw_may_wrap(default):
    """The same robot, that turns left, seen from the north: its yaw goes over ±180°."""
    step, session = default
    turned, targets = [0.0, 3.1], []
    for offset in turned:
        state, found = np.zeros((1, step.state_size)), []
        for tick in range(40):
            given, half = readings(step, tick), 0.5 * (offset + 0.01 * tick)
            given["command"] = np.array([[0.3, 0.0, 0.5]])
            given["quaternion"] = np.array([[np.cos(half), 0.0, 0.0, np.sin(half)]])
            result, state = session.run(None, given | {"state": state})
            found.append(result)
        targets.append(found)
    np.testing.assert_allclose(*targets, atol=1e-6)


def test_an_action_beyond_the_limits_of_the_joints_stops_there(tmp_path):
    policy = make_policy("env.action.clip=100.0")
    policy.network.mlp[-1].bias.data[:] = 1e30  # type: ignore[union-attr]
    step = policy_step(policy)
    session = graph(step, tmp_path / "policy.onnx")
    fresh = np.zeros((1, step.state_size))
    targets, _ = session.run(None, readings(step, 0) | {"state": fresh})
    moved = np.arange(12) % 6 != 5
    np.testing.assert_array_equal(targets[0, moved], policy.robot.joint_ranges[1][moved])
