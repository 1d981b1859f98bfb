"""Check 9: what happens between the nodes, where the optimisation does not look.

Joints follow their Bézier polynomials and the roll a quintic through its nodes; its acceleration
is the one that leaves no moment about the foot line, so that torques and forces are consistent.
"""

from dataclasses import dataclass

import numpy as np

from slider.core.config.gait import Posture
from slider.core.config.robot import RobotConfig
from slider.robot import knee_map
from slider.robot.names import SIDES
from slider.verification.pin_robot import PinRobot
from slider.verification.stored import LEG, StepMotion, StoredGait

_ROTARY = ("hip_yaw", "hip_roll", "hip_pitch", "ankle")


@dataclass(frozen=True)
class DenseStep:
    """N points of one step, the stance foot at the world's origin.

    Attributes:
        phase: (N,) in [0, 1].
        q, v, torques: (N, 10) [rad], [rad/s], [N m]; left leg, right leg.
        wrench: (N, 6) ground force [N] and moment [N m] at the middle of the foot line.
        ends: (N, 2, 3) toe and heel of the swing foot [m].
        defect: (N,) roll acceleration of the quintic minus the dynamics' [rad/s²].
    """

    phase: np.ndarray
    q: np.ndarray
    v: np.ndarray
    torques: np.ndarray
    wrench: np.ndarray
    ends: np.ndarray
    defect: np.ndarray


def resample(motion: StepMotion, robot: PinRobot, points: int) -> DenseStep:
    """Evaluate a step at equally spaced times, its ends included."""
    phase = np.linspace(0.0, 1.0, points)
    roll = motion.roll_at(phase * motion.duration)
    q, v, a = motion.joints_at(phase * motion.duration)
    other = SIDES[1 - SIDES.index(motion.side)]
    rows = []
    for k in range(points):
        still = robot.standing(np.array([*roll[k, :2], 0.0]), q[k], v[k], a[k], motion.side)
        moment, inertia = robot.line_moment_and_inertia(still, motion.side)
        bend = np.array([*roll[k, :2], -moment / inertia])
        state = robot.standing(bend, q[k], v[k], a[k], motion.side)
        torques, wrench = robot.inverse_dynamics(state, motion.side)
        ends = robot.foot_ends(state.q, other)
        rows.append((torques, wrench, ends, roll[k, 2] - bend[2]))
    torques, wrench, ends, defect = (np.array(column) for column in zip(*rows, strict=True))
    return DenseStep(phase, q, v, torques, wrench, ends, defect)


def between_nodes(
    gait: StoredGait,
    pinocchio: PinRobot,
    robot: RobotConfig,
    posture: Posture,
    points: int,
) -> dict[str, float]:
    """Worst values over both steps; see ``slider.verification.quantities``."""
    values: dict[str, list[float]] = {}
    for motion in gait.steps:
        step = resample(motion, pinocchio, points)
        found = _clearance(step, posture.clearance)
        found |= _contact(step, pinocchio) | _drives(step, robot)
        found["dense_roll_defect"] = float(np.abs(step.defect).max())
        for name, value in found.items():
            values.setdefault(name, []).append(value)
    return {name: max(both) for name, both in values.items()}


def _clearance(step: DenseStep, clearance: float) -> dict[str, float]:
    """How far toe and heel come below the ground and below the parabola of the posture [m]."""
    lowest = step.ends[..., 2].min(axis=1)
    wanted = 4.0 * clearance * step.phase * (1.0 - step.phase)
    return {
        "dense_penetration": float(max(0.0, -lowest.min())),
        "dense_clearance": float(max(0.0, (wanted - lowest).max())),
    }


def _contact(step: DenseStep, robot: PinRobot) -> dict[str, float]:
    """Centre of pressure as a share of the foot; friction [-] that the foot and its ends need."""
    force, moment = step.wrench[:, :3], step.wrench[:, 3:]
    place = -moment[:, 1] / force[:, 2]
    toe, heel = robot.ends[:, 0]
    toe_z = force[:, 2] * (place - heel) / (toe - heel)
    toe_y = (moment[:, 2] - heel * force[:, 1]) / (toe - heel)
    sliding = np.hypot(force[:, 0], force[:, 1]) / force[:, 2]
    ends = [np.abs(toe_y / toe_z), np.abs((force[:, 1] - toe_y) / (force[:, 2] - toe_z))]
    return {
        "dense_cop": float(np.maximum(place / toe, place / heel).max()),
        "dense_friction": float(sliding.max()),
        "dense_friction_ends": float(np.max(ends)),
    }


def _drives(step: DenseStep, robot: RobotConfig) -> dict[str, float]:
    """Efforts, speeds and positions of the prismatic drives, as shares of their limits."""
    knee = robot.virtual_knee
    lengths = (knee.thigh_length, knee.shank_length)
    worst: dict[str, list[float]] = {
        "torque": [],
        "slide_force": [],
        "speed": [],
        "slide_speed": [],
    }
    beyond = []
    for leg in (slice(0, LEG), slice(LEG, 2 * LEG)):
        q, v, t = step.q[:, leg].T, step.v[:, leg].T, step.torques[:, leg].T
        place = knee_map.positions(q[2], q[3], q[4], *lengths)
        rate = knee_map.velocities(v[2], q[3], v[3], v[4], *lengths)
        force = knee_map.slide_force(t[3], t[2], t[4], q[3], *lengths)
        slide = robot.limits["slide"]
        efforts, speeds = (t[0], t[1], t[2], t[4]), (v[0], v[1], rate.hip_pitch, rate.ankle)
        limits = [robot.limits[name] for name in _ROTARY]
        worst["torque"] += [_share(e, x.effort) for e, x in zip(efforts, limits, strict=True)]
        worst["speed"] += [_share(s, x.speed) for s, x in zip(speeds, limits, strict=True)]
        worst["slide_force"].append(_share(force, slide.effort))
        worst["slide_speed"].append(_share(rate.length, slide.speed))
        angles = (q[0], q[1], place.hip_pitch, place.ankle)
        stroke = place.length - robot.geometry.leg_length
        for values, x in zip((*angles, stroke), (*limits, slide), strict=True):
            beyond.append(float(np.maximum(values - x.upper, x.lower - values).max()))
    found = {f"dense_{name}": max(values) for name, values in worst.items()}
    return found | {"dense_position": max(0.0, *beyond)}


def _share(values: np.ndarray, limit: float) -> float:
    return float(np.abs(values).max() / limit)
