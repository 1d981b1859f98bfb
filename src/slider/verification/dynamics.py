"""Checks 1 and 2: inverse dynamics and impacts by pinocchio, from the stored samples."""

import numpy as np

from slider.robot.kinematics import rotation_from_quaternion
from slider.robot.names import SIDES
from slider.verification.pin_robot import FloatingState, PinRobot
from slider.verification.stored import StepMotion, StoredGait

_BASE = 6


def stored_state(gait: StoredGait, robot: PinRobot, sample: int) -> FloatingState:
    """A sample as it is stored; the world's origin is the stance foot.

    The library stores no accelerations: they follow from the coefficients and the foot's roll.
    """
    step = gait.step_of(sample)
    base = gait.base[sample]
    rotation = rotation_from_quaternion(base[None, 3:7])[0]
    w, x, y, z = base[3:7]
    q = np.concatenate([base[:3] - gait.origin(step), [x, y, z, w], gait.knee_positions[sample]])
    v = np.concatenate([rotation.T @ base[7:10], base[10:13], gait.knee_velocities[sample]])
    return FloatingState(q, v, _sample_state(gait, robot, sample).a)


def moving_state(motion: StepMotion, robot: PinRobot, time: float) -> FloatingState:
    """What the coefficients and the roll of the stance foot describe at a time of a step."""
    return robot.standing(motion.roll_at(time), *motion.joints_at(time), motion.side)


def inverse_dynamics(gait: StoredGait, robot: PinRobot) -> dict[str, float]:
    """Residuals of the equations of motion at all nodes under the stored ground wrench.

    Returns:
        Worst joint torque [N m], force and moment left on the floating base [N, N m], and stored
        moment about the foot line [N m].
    """
    torque, base = [], []
    for sample in range(2 * gait.half):
        state = stored_state(gait, robot, sample)
        jacobian = robot.jacobian(state.q, SIDES[gait.step_of(sample)])
        total = robot.forces(state)
        rest = total - jacobian.T @ gait.ground_wrench[sample]
        base.append(_worst(rest[:_BASE]))
        torque.append(_worst(rest[_BASE:] - gait.knee_torques[sample]))
    return {
        "dynamics_torque": max(torque),
        "dynamics_base": max(base),
        "dynamics_line_moment": _worst(gait.ground_wrench[:, 3]),
    }


def kinematics(gait: StoredGait, robot: PinRobot) -> dict[str, float]:
    """Stored joints, base, swing foot and times against coefficients and a foot that only rolls."""
    position, velocity = [], []
    for sample in range(2 * gait.half):
        found, expected = stored_state(gait, robot, sample), _sample_state(gait, robot, sample)
        position.append(_worst(robot.difference(expected.q, found.q)))
        velocity.append(_worst(found.v - expected.v))
        swing = robot.sole_place(expected.q, SIDES[1 - gait.step_of(sample)])
        position.append(_worst(swing - gait.swing_foot[sample]))
    return {
        "kinematics_position": max(position),
        "kinematics_velocity": max(velocity),
        "kinematics_time": _worst(gait.time - _times(gait)),
    }


def _times(gait: StoredGait) -> np.ndarray:
    """Equally spaced over each step; the second begins when the first ends."""
    first, second = gait.step_time
    phase = np.linspace(0.0, 1.0, gait.half)
    return np.concatenate([phase * first, first + phase * second])


def impact(gait: StoredGait, robot: PinRobot) -> dict[str, float]:
    """Plastic impacts at both touchdowns: velocities after it, and the impulse that is left.

    Returns:
        Worst velocity [rad/s, m/s] against the solution of mass matrix and contact Jacobian, and
        worst joint impulse or moment about the line [N m s] that the stored velocities need.
    """
    velocity, impulse = [], []
    for step in range(2):
        before = stored_state(gait, robot, (step + 1) * gait.half - 1)
        after = stored_state(gait, robot, (step + 1) * gait.half % (2 * gait.half))
        side = SIDES[1 - step]
        velocity.append(_worst(robot.impact(before.q, before.v, side) - after.v))
        impulse.append(_worst(robot.impulse(before.q, before.v, after.v, side)))
    return {"impact_velocity": max(velocity), "impact_impulse": max(impulse)}


def _sample_state(gait: StoredGait, robot: PinRobot, sample: int) -> FloatingState:
    step = gait.step_of(sample)
    return moving_state(gait.steps[step], robot, gait.time_in_step(sample))


def _worst(values: np.ndarray) -> float:
    return float(np.abs(values).max())
