"""Check 6: the motion between the nodes, where the optimisation has no constraints.

Joints follow their Bézier polynomials and the roll a quintic through its nodes; its acceleration
is the one that leaves no moment about the foot line, so that torques and forces are consistent.
"""

from dataclasses import dataclass

import numpy as np

from slider.config.gait import Posture
from slider.config.robot import Mechanism
from slider.robot.knee_map import prismatic_motion
from slider.robot.names import other_side
from slider.robot.transmission import Transmission
from slider.verification.pin_robot import PinRobot, full
from slider.verification.plant import Plant, plant_state, pressure_share
from slider.verification.quantities import worst
from slider.verification.stored import StepMotion, StoredGait


@dataclass(frozen=True)
class DenseStep:
    """N points of one step, the stance foot at the world's origin.

    Attributes:
        phase: (N,) in [0, 1].
        joints, speeds, efforts: (N, 12) of the prismatic legs [rad, m], [rad/s, m/s], [N m, N].
        wrench: (N, 6) ground force [N] and moment [N m] at the middle of the foot line.
        ends: (N, 2, 3) toe and heel of the swing foot [m].
    """

    phase: np.ndarray
    joints: np.ndarray
    speeds: np.ndarray
    efforts: np.ndarray
    wrench: np.ndarray
    ends: np.ndarray


def resample(motion: StepMotion, robot: PinRobot, points: int) -> DenseStep:
    """Evaluate a step at equally spaced times, its ends included."""
    phase = np.linspace(0.0, 1.0, points)
    rows = []
    for time in phase * motion.duration:
        roll = motion.roll_at(time)[:2]
        turn = robot.free_roll(motion, time, roll)
        state = robot.moving(motion, time, np.array([*roll, turn]))
        forces, wrench = robot.inverse_dynamics(state, motion.side)
        _, efforts = robot.work(motion.joints_at(time)[0], forces)
        ends = robot.foot_ends(state.q, other_side(motion.side))
        rows.append((full(efforts), wrench, ends, state.q[7:], state.v[6:]))
    efforts, wrench, ends, *own = (np.array(column) for column in zip(*rows, strict=True))
    motions = motion.joints_at(phase * motion.duration)
    joints, speeds, _ = prismatic_motion(*motions, robot.lengths)
    joints, speeds = (full(values) for values in ((joints, speeds) if robot.soles is None else own))
    return DenseStep(phase, joints, speeds, efforts, wrench, ends)


def between_nodes(
    gait: StoredGait, pinocchio: PinRobot, robot: Mechanism, posture: Posture, points: int
) -> dict[str, float]:
    """Worst values over both steps; see ``slider.verification.quantities``."""
    motors, (lower, upper) = Transmission.of(robot), robot.joint_ranges
    rows = []
    for motion in gait.steps:
        step = resample(motion, pinocchio, points)
        lowest = step.ends[..., 2].min(axis=1)
        parabola = 4.0 * posture.clearance * step.phase * (1.0 - step.phase)
        force = step.wrench[:, :3]
        torque, voltage = motors.shares(step.efforts, step.speeds)
        beyond = np.maximum(step.joints - upper, lower - step.joints)
        rows.append(
            {
                "dense_penetration": np.maximum(0.0, -lowest),
                "dense_clearance": np.maximum(0.0, parabola - lowest),
                "dense_cop": pressure_share(step.wrench, pinocchio),
                "dense_friction": np.hypot(force[:, 0], force[:, 1]) / force[:, 2],
                "dense_torque": torque,
                "dense_voltage": voltage,
                "dense_position": np.maximum(0.0, beyond),
            }
        )
    return worst(rows)


def legs_apart(gait: StoredGait, plant: Plant, points: int) -> dict[str, float]:
    """Least distance [m] of the plant's legs from each other over the walk."""
    distances = [
        plant.leg_distance(plant_state(plant.slides.moving(motion, time)))
        for motion in gait.steps
        for time in np.linspace(0.0, motion.duration, points)
    ]
    return {"dense_leg_distance": float(np.min(distances))}
