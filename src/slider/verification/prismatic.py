"""Check 8: the converted gait on the prismatic robot, in MuJoCo's inverse dynamics.

The prismatic leg has its mass elsewhere than the virtual-knee leg, so that the stored ground force
no longer carries the motion; what is left on the base is the price of that assumption.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass

import mujoco
import numpy as np

from slider.core.config.robot import RobotConfig
from slider.robot import knee_map, names
from slider.robot.kinematics import rotation_from_quaternion
from slider.robot.mjcf import SimulationOptions, build_model
from slider.verification.dynamics import moving_state
from slider.verification.pin_robot import PinRobot
from slider.verification.stored import LEG, StoredGait

_STEP = 1e-6  # of central differences over time [s] and knee angle [rad]
_PRISMATIC = len(names.LEG_JOINTS)
_BASE = 6


@dataclass(frozen=True)
class PrismaticState:
    """qpos (19,), qvel (18,) and qacc (18,) of the MuJoCo model."""

    qpos: np.ndarray
    qvel: np.ndarray
    qacc: np.ndarray


class PrismaticRobot:
    """MuJoCo's inverse dynamics of the prismatic robot without contacts and joint limits."""

    def __init__(self, robot: RobotConfig) -> None:
        self.robot = robot
        self.model = build_model(robot, SimulationOptions())
        off = mujoco.mjtDisableBit
        self.model.opt.disableflags |= int(off.mjDSBL_CONTACT) | int(off.mjDSBL_LIMIT)
        self.data = mujoco.MjData(self.model)

    def residual(self, state: PrismaticState, wrench: np.ndarray, side: str) -> np.ndarray:
        """Force [N] and moment [N m] (6,) left on the base, at its origin, world axes.

        ``wrench`` (6,) acts on the foot at the middle of its line, world axes.
        """
        forces, jacobian = self._inverse(state, side)
        rest = (forces - jacobian.T @ wrench)[:_BASE]
        rotation = self.data.body(names.BASE).xmat.reshape(3, 3)
        return np.concatenate([rest[:3], rotation @ rest[3:]])

    def efforts(self, state: PrismaticState, side: str) -> np.ndarray:
        """Joint efforts (12,) [N m, N] under the ground wrench that balances the base best.

        A line foot carries no moment about its line: that component is left out.
        """
        forces, jacobian = self._inverse(state, side)
        wrench = np.linalg.solve(jacobian[:, :_BASE].T, forces[:_BASE])
        wrench[3] = 0.0
        return (forces - jacobian.T @ wrench)[_BASE:]

    def _inverse(self, state: PrismaticState, side: str) -> tuple[np.ndarray, np.ndarray]:
        """Generalised forces (18,) of a motion, Jacobian (6, 18) of the sole, world axes."""
        data = self.data
        data.qpos[:], data.qvel[:], data.qacc[:] = state.qpos, state.qvel, state.qacc
        mujoco.mj_inverse(self.model, data)
        jacobian = np.zeros((_BASE, self.model.nv))
        place = data.site(names.sole(side))
        mujoco.mj_jacSite(self.model, data, jacobian[:3], jacobian[3:], place.id)
        return data.qfrc_inverse.copy(), jacobian


def residual_wrench(
    gait: StoredGait, pinocchio: PinRobot, prismatic: PrismaticRobot
) -> dict[str, float]:
    """Root mean square over the nodes of force [N] and moment [N m], for both maps of eq. 1."""
    found = {}
    for variant in knee_map.VARIANTS:
        rows = np.array(
            [_sample(gait, pinocchio, prismatic, k, variant) for k in range(2 * gait.half)]
        )
        for name, part in (("force", rows[:, :3]), ("moment", rows[:, 3:])):
            found[f"wrench_{name}_{variant}"] = float(np.sqrt((part**2).sum(axis=1).mean()))
    return found


def _sample(
    gait: StoredGait, pinocchio: PinRobot, prismatic: PrismaticRobot, sample: int, variant: str
) -> np.ndarray:
    step = gait.step_of(sample)
    time = gait.time_in_step(sample)
    state = converted_at(gait, pinocchio, prismatic.robot, step, time, variant)
    side = names.SIDES[step]
    return prismatic.residual(state, gait.ground_wrench[sample], side)


def converted_at(
    gait: StoredGait, pinocchio: PinRobot, robot: RobotConfig, step: int, time: float, variant: str
) -> PrismaticState:
    """The motion at a time of a step after eq. 1; the base moves as in the virtual-knee model."""
    floating = moving_state(gait.steps[step], pinocchio, time)
    x, y, z, w = floating.q[3:7]
    rotation = rotation_from_quaternion(np.array([[w, x, y, z]]))[0]
    linear, angular = floating.v[:3], floating.v[3:6]
    q, v, a = prismatic_motion(gait, robot, step, time, variant)
    return PrismaticState(
        np.concatenate([floating.q[:3], [w, x, y, z], q]),
        np.concatenate([rotation @ linear, angular, v]),
        np.concatenate(
            [rotation @ (floating.a[:3] + np.cross(angular, linear)), floating.a[3:6], a]
        ),
    )


def prismatic_motion(
    gait: StoredGait, robot: RobotConfig, step: int, time: float, variant: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Joint positions, velocities and accelerations (12,); the last by central differences."""
    q, v = _joints(gait, robot, step, time, variant)
    _, above = _joints(gait, robot, step, time + _STEP, variant)
    _, below = _joints(gait, robot, step, time - _STEP, variant)
    return q, v, (above - below) / (2 * _STEP)


def _joints(
    gait: StoredGait, robot: RobotConfig, step: int, time: float, variant: str
) -> tuple[np.ndarray, np.ndarray]:
    knee = robot.virtual_knee
    lengths = (knee.thigh_length, knee.shank_length)
    q, v, _ = gait.steps[step].joints_at(time)
    position, velocity = np.zeros(names.NUM_JOINTS), np.zeros(names.NUM_JOINTS)
    for leg in range(2):
        p, r = q[leg * LEG : (leg + 1) * LEG], v[leg * LEG : (leg + 1) * LEG]
        place = knee_map.positions(p[2], p[3], p[4], *lengths, variant)
        rate = knee_map.velocities(r[2], p[3], r[3], r[4], *lengths, variant)
        to = slice(leg * _PRISMATIC, (leg + 1) * _PRISMATIC - 1)  # the upper foot stays 0
        stroke = place.length - robot.geometry.leg_length
        position[to] = [p[0], p[1], place.hip_pitch, stroke, place.ankle]
        velocity[to] = [r[0], r[1], rate.hip_pitch, rate.length, rate.ankle]
    return position, velocity


def stored_samples(gait: StoredGait, robot: RobotConfig, variant: str) -> dict[str, float]:
    """Stored channels [rad, m, 1/s] against eq. 1 and the base, stored efforts [N m, N] against
    virtual work.
    """
    channels, efforts = [], []
    for sample in range(2 * gait.half):
        step, time = gait.step_of(sample), gait.time_in_step(sample)
        joints = np.concatenate(_joints(gait, robot, step, time, variant))
        expected = np.concatenate([joints, _heading_velocity(gait.base[sample])])
        channels.append(np.abs(gait.samples[sample] - expected).max())
        efforts.append(np.abs(gait.efforts[sample] - _efforts(gait, robot, sample)).max())
    return {"kinematics_samples": float(max(channels)), "dynamics_efforts": float(max(efforts))}


def _heading_velocity(base: np.ndarray) -> np.ndarray:
    """Forward and leftward velocity (2,) [m/s] of the base in its heading frame."""
    w, x, y, z = base[3:7]
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    forward, leftward = base[7:9]
    return np.array(
        [
            np.cos(yaw) * forward + np.sin(yaw) * leftward,
            np.cos(yaw) * leftward - np.sin(yaw) * forward,
        ]
    )


def _efforts(gait: StoredGait, robot: RobotConfig, sample: int) -> np.ndarray:
    """Efforts (12,) that do the work of the stored torques, whatever map the samples have.

    The slide's rate of change with the knee is a central difference of the leg's length.
    """
    knee = robot.virtual_knee
    lengths = (knee.thigh_length, knee.shank_length)
    efforts = np.zeros(names.NUM_JOINTS)
    for leg in range(2):
        own = slice(leg * LEG, (leg + 1) * LEG)
        (_, _, pitch, theta, ankle), t = (
            gait.knee_positions[sample, own],
            gait.knee_torques[sample, own],
        )
        above, below = (
            knee_map.positions(pitch, theta + sign * _STEP, ankle, *lengths) for sign in (1.0, -1.0)
        )
        hip, stroke, foot = (
            (getattr(above, name) - getattr(below, name)) / (2 * _STEP)
            for name in ("hip_pitch", "length", "ankle")
        )
        force = (t[3] - hip * t[2] - foot * t[4]) / stroke
        efforts[leg * _PRISMATIC : (leg + 1) * _PRISMATIC - 1] = [t[0], t[1], t[2], force, t[4]]
    return efforts
