"""The graphs do what policy and estimator of this package do, and survive bad readings."""

import numpy as np
import onnxruntime
import pytest

from slider.control.deployment import Step, estimator_step, policy_step
from slider.control.export import Both
from slider.control.exported import OnnxController
from slider.control.onnx_graph import save
from slider.control.policy import Policy, PolicyController
from slider.env.estimator import StateEstimator
from slider.env.interface import AgentInterface
from slider.env.physics import BatchedPhysics
from slider.env.rollout import roll_out
from slider.env.starts import USUAL_NOISE, at_rest
from slider.robot.kinematics import rotation_from_quaternion
from slider.robot.transmission import Transmission
from tests.control import policies
from tests.control.policies import make_policy
from tests.env.synthetic import TURNING, config, gait_table, make_arrays
from tests.env.test_estimator import LEGS

VELOCITY = np.array([0.3, 0.05, 0.4])  # turning, between the gaits of the library
STEPS, STARTED, STOPPED = 65, 5, 45  # the command is zero before and afterwards
LONG = 250  # 5 s
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
        (("env/observation=seeing", "env.phase.mirror=false", "env.action.offset=nominal"), True),
        (("env.phase.halt={below: 5.0, above: 5.0}", "env.reference.acceleration=0"), False),
    ],
)
def test_the_graph_acts_like_the_policy(tmp_path, monkeypatch, overrides, turning):
    """Robots that start and stop, in closed loop."""
    if turning:
        monkeypatch.setattr(policies, "gait_table", lambda: gait_table(*TURNING))
    policy = make_policy(*overrides)
    controllers = both(policy, tmp_path / "policy.onnx", COUNT)
    physics = BatchedPhysics(policy.robot, policy.env.physics, COUNT)
    start = at_rest(policy.robot, USUAL_NOISE, np.random.default_rng(0), COUNT)
    half = np.pi / 2 * np.array([0.999, -0.999, 0.0])
    start[0][:, 3:7] = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)
    start[1][:, 5] = half
    steps = STEPS if overrides or turning else LONG
    commands = np.zeros((steps, COUNT, 3))
    commands[STARTED:STOPPED] = np.array([[1.0], [-0.5], [0.0]]) * VELOCITY
    seconds = steps * policy.env.control_period
    recording = roll_out(controllers, physics, policy.env, start, commands, seconds)
    assert (recording.yaw * half < 0)[:, :2].any(axis=0).all(), "yaws go over ±180°"
    assert controllers.difference < 1e-6
    assert np.ptp(controllers.targets, axis=0).max() > 1e-3, "robots must do different things"


def readings(step: Step, seed: int, count: int = 1) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    given = {
        name: reading.default + 0.02 * rng.standard_normal((count, len(reading.default)))
        for name, reading in step.readings.items()
    }
    given["quaternion"] /= np.linalg.norm(given["quaternion"], axis=1, keepdims=True)
    return given


@pytest.mark.parametrize("robot", [LEGS["slider"], LEGS["turned"]], ids=["slider", "turned"])
def test_the_graph_estimates_like_the_package(robot, tmp_path):
    """On arrays; of robots in any motion."""
    settings = config("experiment=test").env.estimator
    step = estimator_step(robot, settings)
    session, state = graph(step, tmp_path / "estimator.onnx"), np.zeros((COUNT, step.state_size))
    package = StateEstimator(settings, robot, COUNT, np.zeros(COUNT))
    for tick in range(5):
        given = readings(step, tick, COUNT) | {"elapsed": np.full((COUNT, 1), 0.02)}
        given["motor_torques"] *= 10.0 * Transmission.of(robot).torque
        velocity, height, state = session.run(None, given | {"state": state})
        increment, elapsed = given.pop("velocity_increment"), given.pop("elapsed")[:, 0]
        turn = rotation_from_quaternion(given["quaternion"])
        sensed = make_arrays(COUNT, rotation=turn, **given)
        found = package.update(sensed, increment, elapsed * (tick > 0))
        expected = np.einsum("nji,nj->ni", turn, found.velocity)
        np.testing.assert_allclose(velocity, expected, atol=1e-9)
        np.testing.assert_allclose(height, found.position[:, 2:], atol=1e-9)
    assert found.foot_forces.any(), "a foot carries"


NAMES = ("joint_positions", "joint_velocities", "linear_velocity", "command")
BAD = [(name, bad) for name in NAMES for bad in (np.nan, np.inf, -np.inf, 1e9)]
TURNS = [[np.nan, 0, 0, 0], [0, 0, 0, 0], [1, np.inf, 0, 0], [9, 0, 0, 0]]


@pytest.mark.parametrize(("name", "bad"), [*BAD, *(("quaternion", turn) for turn in TURNS)])
@pytest.mark.parametrize("first", [True, False])
def test_a_bad_value_counts_as_the_one_before_or_the_default(default, name, bad, first):
    step, session = default
    before = {key: np.array([reading.default]) for key, reading in step.readings.items()}
    state = np.zeros((1, step.state_size))
    if not first:
        before = readings(step, 0)
        _, state = session.run(None, before | {"state": state})
    now, held = readings(step, 1), readings(step, 1)
    place = slice(None) if name == "quaternion" else 0
    now[name][0, place], held[name][0, place] = bad, before[name][0, place]
    found, expected = (session.run(None, given | {"state": state}) for given in (now, held))
    for value, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(value, other)


def test_an_action_beyond_the_limits_of_the_joints_stops_there(tmp_path):
    policy = make_policy("env.action.clip=100.0")
    policy.network.mlp[-1].bias.data[:] = 1e30  # type: ignore[union-attr]
    step = policy_step(policy)
    session = graph(step, tmp_path / "policy.onnx")
    fresh = np.zeros((1, step.state_size))
    targets, _ = session.run(None, readings(step, 0) | {"state": fresh})
    moved = np.arange(12) % 6 != 5
    np.testing.assert_array_equal(targets[0, moved], policy.robot.joint_ranges[1][moved])
