"""The rooted Newton-Euler dynamics against pinocchio's floating-base robot."""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from slider.gait.formulation import Formulation
from slider.gait.transcription import NODE
from slider.robot.names import SIDES
from slider.verification.pin_robot import FloatingState, PinRobot
from tests.gait.gaits import config, inverse_dynamics, nodes, problem, trajectory

VELOCITIES = [(0.6, 0.1), (1.2, 0.0)]
DYNAMICS = ["prismatic", "knee"]


def uneven():
    """The robot with a thigh that is longer than the shank, so that no term vanishes."""
    robot = config().robot
    return replace(robot, virtual_knee=replace(robot.virtual_knee, thigh_length=0.39))


@cache
def robot(dynamics: str = "prismatic", *, even: bool = True) -> PinRobot:
    return PinRobot(config().robot if even else uneven(), dynamics)


@cache
def rooted(dynamics: str, *, even: bool = True) -> ca.Function:
    settings = replace(config().gait, dynamics=dynamics)
    return inverse_dynamics(Formulation(config().robot if even else uneven(), settings))


def compare(x: np.ndarray, dynamics: str, *, even: bool = True, atol: float = 1e-8) -> None:
    results = [np.array(value).ravel() for value in rooted(dynamics, even=even)(x)]
    pinocchio, time = robot(dynamics, even=even), x[-1]
    q = x[3:13]
    joints = pinocchio.joint_motion(q, x[13:23] / time, x[23:33] / time**2)
    forces, wrench = pinocchio.inverse_dynamics(pinocchio.standing(x[:3], *joints))
    expected = [*pinocchio.work(q, forces), wrench[:3], wrench[3:]]
    for value, right in zip(results, expected, strict=True):
        np.testing.assert_allclose(value, right, atol=atol)


@pytest.mark.parametrize("dynamics", DYNAMICS)
@pytest.mark.parametrize("even", [True, False])
def test_random_motions(dynamics, even):
    rng = np.random.default_rng(0)
    for _ in range(20):
        x = np.concatenate(
            [rng.normal(size=33) * [0.2, 1, 5, *[0.5] * 10, *[1] * 10, *[2] * 10], [1]]
        )
        x[[6, 11]] = rng.uniform(0.3, 1.5, 2)  # knees: the slide's force needs them bent
        compare(x, dynamics, even=even)


def test_rotors_and_friction_are_part_of_the_prismatic_legs_only():
    """A hip that turns alone, the leg straight down: what the drives add is I q̈ + d q̇."""
    x = np.zeros(NODE)
    x[[6, 11]], x[-1] = 0.5, 1.0
    drives, joints = config().robot.drives, config().robot.joints
    drive, joint = drives["hip_yaw"], joints["hip_yaw"]
    bare = replace(
        config().robot,
        drives=drives | {"hip_yaw": replace(drive, inertia=1e-12)},
        joints=joints | {"hip_yaw": replace(joint, damping=0.0)},
    )
    x[18], x[28] = 1.5, 7.0  # swing hip yaw: rate and acceleration
    without = inverse_dynamics(Formulation(bare, config().gait))
    added = (rooted("prismatic")(x)[1] - without(x)[1]).full().ravel()
    np.testing.assert_allclose(added[5], drive.inertia * 7.0 + joint.damping * 1.5, atol=1e-9)
    np.testing.assert_allclose(np.delete(added, 5), 0.0, atol=1e-9)


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_all_nodes_of_a_gait(velocity):
    for x in nodes(*velocity):
        compare(x, "prismatic")


def floating(velocity: tuple[float, float], sample: int) -> FloatingState:
    """A sample of the walk as it is in the world, from the gait's own base motion."""
    t = trajectory(*velocity)
    pose = pin.SE3(t.base_rotation[sample], t.base_position[sample])
    joints, rates, _ = robot().joint_motion(t.q[sample], t.v[sample], np.zeros(10))
    q = np.concatenate([pin.SE3ToXYZQUAT(pose), joints])
    linear = t.base_rotation[sample].T @ t.base_velocity[sample]
    v = np.concatenate([linear, t.base_angular[sample], rates])
    return FloatingState(q, v, np.zeros(16))


@pytest.mark.parametrize("velocity", VELOCITIES)
@pytest.mark.parametrize("step", [0, 1])
def test_impact_keeps_the_angular_momentum_about_the_new_foot_line(velocity, step):
    half, side = problem().layout.nodes, SIDES[1 - step]
    before = floating(velocity, (step + 1) * half - 1)
    after = floating(velocity, ((step + 1) * half) % (2 * half))
    found = robot().impact(before.q, before.v, side)
    np.testing.assert_allclose(found[3:], after.v[3:], atol=1e-6)
    robot().jacobian(before.q, side)
    sole = robot().data.oMf[robot().sole(side)].translation.copy()
    lost = momentum_about(before, sole)[0]
    kept = momentum_about(after, np.zeros(3))[0]
    assert abs(lost) > 0.1
    assert kept == pytest.approx(lost, abs=1e-7)


def momentum_about(state: FloatingState, point: np.ndarray) -> np.ndarray:
    """Angular momentum (3,) about a point, world axes."""
    pin.computeCentroidalMomentum(robot().model, robot().data, state.q, state.v)
    momentum = robot().data.hg
    return momentum.angular + np.cross(robot().data.com[0] - point, momentum.linear)
