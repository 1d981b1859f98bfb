"""Check 5: stored gaits against MuJoCo's inverse dynamics and mass matrix.

The plant is the model that policies control, without contacts and joint limits. In gaits the upper
feet are fixed to the tubes.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass

import mujoco
import numpy as np

from slider.config.robot import RobotConfig
from slider.robot import names
from slider.robot.kinematics import rotation_from_quaternion
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.transmission import Transmission
from slider.verification.dynamics import stored_state, touchdowns
from slider.verification.pin_robot import FloatingState, PinRobot, after_impact, full, levelling
from slider.verification.quantities import worst
from slider.verification.stored import StoredGait

_BASE = 6
_FAR = 10.0  # cut-off of distances [m]


@dataclass(frozen=True)
class PlantState:
    """qpos (19,), qvel (18,) and qacc (18,) of the MuJoCo model."""

    qpos: np.ndarray
    qvel: np.ndarray
    qacc: np.ndarray


class Plant:
    """MuJoCo's model; its motion comes from the prismatic robot's kinematics."""

    def __init__(self, robot: RobotConfig) -> None:
        self.slides = PinRobot(robot, "prismatic")
        self.motors = Transmission.of(robot)
        self.driven = np.array(names.driven_joints(robot.geometry))
        self.dofs = np.append(np.arange(_BASE), _BASE + self.driven)  # without held upper feet
        self.model = build_model(robot, SimulationOptions())
        off = mujoco.mjtDisableBit
        self.model.opt.disableflags |= int(off.mjDSBL_CONTACT) | int(off.mjDSBL_LIMIT)
        self.data = mujoco.MjData(self.model)
        self.pairs = [
            (self.model.geom(first).id, self.model.geom(second).id)
            for first, second in names.LEG_PAIRS
        ]

    def inverse(self, state: PlantState, side: str) -> tuple[np.ndarray, np.ndarray]:
        """Generalised forces (18,) of a motion, Jacobian (6, 18) of the sole, world axes."""
        data = self.data
        data.qpos[:], data.qvel[:], data.qacc[:] = state.qpos, state.qvel, state.qacc
        mujoco.mj_inverse(self.model, data)
        return data.qfrc_inverse.copy(), self._jacobian(side)

    def balanced(self, state: PlantState, side: str) -> tuple[np.ndarray, np.ndarray]:
        """Joint efforts (12,) [N m, N] under the ground wrench (6,) that balances the base best.

        A line foot carries no moment about its line: that component is left out.
        """
        forces, jacobian = self.inverse(state, side)
        wrench = np.linalg.solve(jacobian[:, :_BASE].T, forces[:_BASE])
        if self.slides.soles is None:
            wrench[3] = 0.0
        return (forces - jacobian.T @ wrench)[_BASE:], wrench

    def impact(self, before: PlantState, side: str) -> np.ndarray:
        """Velocities (16,) or (18,) after a foot's impact, upper feet locked on the tubes."""
        data, model, dofs = self.data, self.model, self.dofs
        data.qpos[:], data.qvel[:] = before.qpos, before.qvel
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        mass, sole, lifted = mass[np.ix_(dofs, dofs)], self._jacobian(side)[:, dofs], None
        if self.slides.soles is not None:
            other = names.other_side(side)
            rotation = data.site(names.sole(other)).xmat.reshape(3, 3)
            lifted = levelling(rotation, self._jacobian(other), other)
        return after_impact(mass, sole, before.qvel[dofs], lifted)

    def leg_distance(self, state: PlantState) -> float:
        """Least distance [m] between the solid parts of one leg and those of the other."""
        self.data.qpos[:] = state.qpos
        mujoco.mj_kinematics(self.model, self.data)
        return min(
            mujoco.mj_geomDistance(self.model, self.data, first, second, _FAR, None)
            for first, second in self.pairs
        )

    def _jacobian(self, side: str) -> np.ndarray:
        jacobian = np.zeros((_BASE, self.model.nv))
        place = self.data.site(names.sole(side)).id
        mujoco.mj_jacSite(self.model, self.data, jacobian[:3], jacobian[3:], place)
        return jacobian


def plant_state(state: FloatingState) -> PlantState:
    """A state of the prismatic pinocchio robot for MuJoCo: linear velocity in the world frame."""
    x, y, z, w = state.q[3:7]
    rotation = rotation_from_quaternion(np.array([[w, x, y, z]]))[0]
    linear, angular = state.v[:3], state.v[3:6]
    acceleration = state.a[:3] + np.cross(angular, linear)
    return PlantState(
        np.concatenate([state.q[:3], [w, x, y, z], full(state.q[7:])]),
        np.concatenate([rotation @ linear, angular, full(state.v[_BASE:])]),
        np.concatenate([rotation @ acceleration, state.a[3:6], full(state.a[_BASE:])]),
    )


def inverse_dynamics(gait: StoredGait, plant: Plant) -> dict[str, float]:
    """Worst values over the samples under the stored ground wrench.

    Returns:
        Force and moment left on the base [N, N m], driven joints' efforts against the stored ones
        [N m, N], and of the plant's own wrench and efforts the centre of pressure and the motors'
        torques and voltages as shares of their limits.
    """
    rows = []
    for sample in range(2 * gait.half):
        side = names.SIDES[gait.step_of(sample)]
        state = plant_state(stored_state(gait, plant.slides, sample))
        forces, jacobian = plant.inverse(state, side)
        rest = forces - jacobian.T @ gait.ground_wrench[sample]
        missed = rest[_BASE:] - gait.efforts[sample]
        efforts, wrench = plant.balanced(state, side)
        torque, voltage = plant.motors.shares(efforts, state.qvel[_BASE:])
        rows.append(
            {
                "plant_force": np.linalg.norm(rest[:3]),
                "plant_moment": np.linalg.norm(rest[3:_BASE]),
                "plant_efforts": missed[plant.driven],
                "plant_cop": pressure_share(wrench, plant.slides),
                "plant_torque": torque,
                "plant_voltage": voltage,
            }
        )
    return worst(rows)


def pressure_share(wrench: np.ndarray, robot: PinRobot) -> np.ndarray:
    """Position of the centre of pressure over toe or heel length, for wrenches (..., 6).

    For a sole, the greater of this and its share of half the width.
    """
    toe, heel = robot.ends[:, 0]
    place = -wrench[..., 4] / wrench[..., 2]
    share = np.maximum(place / toe, place / heel)
    if robot.soles is None:
        return share
    return np.maximum(share, np.abs(wrench[..., 3] / wrench[..., 2]) * 2 / robot.soles.width)


def impact(gait: StoredGait, plant: Plant) -> dict[str, float]:
    """Stored velocities after touchdown against the plant's plastic impact [rad/s, m/s]."""
    errors = (
        plant.impact(plant_state(before), side) - plant_state(after).qvel[plant.dofs]
        for before, after, side in touchdowns(gait, plant.slides)
    )
    return worst([{"plant_impact": error} for error in errors])
