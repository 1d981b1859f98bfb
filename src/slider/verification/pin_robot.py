"""The robot as a floating-base pinocchio model: an independent dynamics."""

# pinocchio lies below cmeel.prefix, where pyright does not look.
# pyright: reportMissingImports=false

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from slider.config.robot import Geometry, Mechanism
from slider.robot.names import LEG_JOINTS, SIDES
from slider.verification.coordinates import (
    Coordinates,
    KneeCoordinates,
    SlideCoordinates,
    SlideMap,
)
from slider.verification.links import LegJoint, inertia_of, knee_leg, prismatic_leg
from slider.verification.stored import StepMotion

WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
_BASE = 6
_Leg = Callable[[Mechanism], list[LegJoint]]
_DYNAMICS: dict[str, tuple[_Leg, type[SlideCoordinates] | type[KneeCoordinates]]] = {
    "prismatic": (prismatic_leg, SlideCoordinates),
    "knee": (knee_leg, KneeCoordinates),
}


@dataclass(frozen=True)
class FloatingState:
    """Configuration (17,), velocity and acceleration (16,) of the floating-base model."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


def build_robot(robot: Mechanism, dynamics: str) -> "PinRobot":
    """The robot whose bodies move as ``gait.dynamics`` says: ``prismatic`` or ``knee``."""
    leg, coordinates = _DYNAMICS[dynamics]
    base = inertia_of(robot.links.base)
    return PinRobot(base, leg(robot), robot.geometry, coordinates(SlideMap.of(robot)))


class PinRobot:
    """Frames ``left_sole`` and ``right_sole`` are the middles of the foot lines."""

    def __init__(
        self,
        base: pin.Inertia,
        leg: list[LegJoint],
        geometry: Geometry,
        coordinates: Coordinates,
    ) -> None:
        self.coordinates = coordinates
        self.model = pin.Model()
        root = self.model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
        self.model.appendBodyToJoint(root, base, pin.SE3.Identity())
        for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
            parent, lateral = root, sign * geometry.hip_offset
            for name, joint in zip(LEG_JOINTS, leg, strict=False):
                place = pin.SE3(np.eye(3), np.array([0.0, lateral, joint.height]))
                parent = self.model.addJoint(parent, joint.kind, place, f"{side}_{name}")
                self.model.appendBodyToJoint(parent, joint.body, pin.SE3.Identity())
                lateral = 0.0
            sole = pin.SE3(np.eye(3), np.array([0.0, 0.0, -geometry.ankle_height]))
            self.model.addFrame(pin.Frame(f"{side}_sole", parent, 0, sole, pin.FrameType.OP_FRAME))
        both = leg * len(SIDES)
        self.model.armature = np.array([0.0] * _BASE + [joint.rotor for joint in both])
        self.damping = np.array([0.0] * _BASE + [joint.damping for joint in both])
        self.ends = np.array([[geometry.toe, 0.0, 0.0], [-geometry.heel, 0.0, 0.0]])
        self.data = self.model.createData()
        self.mass_total = pin.computeTotalMass(self.model)

    def moving(
        self, motion: StepMotion, time: float, roll: np.ndarray | None = None
    ) -> FloatingState:
        """State at a time of a step; ``roll`` (3,) replaces the foot's stored one."""
        joints = self.coordinates.motion(*motion.joints_at(time))
        return self.standing(motion.roll_at(time) if roll is None else roll, *joints, motion.side)

    def sole(self, side: str) -> int:
        """Frame of a sole."""
        return self.model.getFrameId(f"{side}_sole")

    def centre(self, q: np.ndarray) -> np.ndarray:
        """Centre of mass (3,) [m]."""
        return pin.centerOfMass(self.model, self.data, q).copy()

    def foot_ends(self, q: np.ndarray, side: str) -> np.ndarray:
        """Toe and heel (2, 3) of a foot line [m]."""
        pin.framesForwardKinematics(self.model, self.data, q)
        place = self.data.oMf[self.sole(side)]
        return self.ends @ place.rotation.T + place.translation

    def forces(self, state: FloatingState) -> np.ndarray:
        """Generalised forces (16,) of a motion [N, N m]: base (its own frame), then joints."""
        free = pin.rnea(self.model, self.data, state.q, state.v, state.a)
        return free + self.damping * state.v

    def jacobian(self, q: np.ndarray, side: str) -> np.ndarray:
        """Jacobian (6, 16) of the sole: linear, angular, world axes."""
        pin.computeJointJacobians(self.model, self.data, q)
        pin.framesForwardKinematics(self.model, self.data, q)
        return pin.getFrameJacobian(self.model, self.data, self.sole(side), WORLD)

    def standing(
        self, roll: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray, side: str = "left"
    ) -> FloatingState:
        """State whose stance sole is at the origin and only rolls: angle, rate, acceleration."""
        place = pin.SE3(pin.exp3(np.array([roll[0], 0.0, 0.0])), np.zeros(3))
        floating = np.concatenate([pin.neutral(self.model)[:7], q])
        pin.framesForwardKinematics(self.model, self.data, floating)
        base = place * self.data.oMf[self.sole(side)].inverse()
        floating[:7] = pin.SE3ToXYZQUAT(base)
        jacobian = self.jacobian(floating, side)
        rate = np.array([0, 0, 0, roll[1], 0, 0]) - jacobian[:, 6:] @ v
        velocity = np.concatenate([np.linalg.solve(jacobian[:, :6], rate), v])
        pin.forwardKinematics(self.model, self.data, floating, velocity, np.zeros(16))
        frame = self.sole(side)
        bias = pin.getFrameClassicalAcceleration(self.model, self.data, frame, WORLD).vector
        turn = np.array([0, 0, 0, roll[2], 0, 0]) - jacobian[:, 6:] @ a - bias
        return FloatingState(
            floating, velocity, np.concatenate([np.linalg.solve(jacobian[:, :6], turn), a])
        )

    def inverse_dynamics(
        self, state: FloatingState, side: str = "left"
    ) -> tuple[np.ndarray, np.ndarray]:
        """Forces (10,) at its joints and ground force and moment (6,) at the stance sole."""
        total = self.forces(state)
        jacobian = self.jacobian(state.q, side)
        wrench = np.linalg.solve(jacobian[:, :6].T, total[:6])
        return total[6:] - jacobian[:, 6:].T @ wrench, wrench

    def mass(self, q: np.ndarray) -> np.ndarray:
        """Joint-space inertia (16, 16), rotors included."""
        upper = np.triu(pin.crba(self.model, self.data, q))
        return upper + np.triu(upper, 1).T

    def impact(self, q: np.ndarray, v: np.ndarray, side: str) -> np.ndarray:
        """Velocity (16,) after a plastic impact: the sole stops but for the rate about x."""
        mass = self.mass(q)
        held = self.jacobian(q, side)[[0, 1, 2, 4, 5]]
        system = np.block([[mass, -held.T], [held, np.zeros((5, 5))]])
        return np.linalg.solve(system, np.concatenate([mass @ v, np.zeros(5)]))[:16]

    def momentum_about(self, q: np.ndarray, v: np.ndarray, point: np.ndarray) -> np.ndarray:
        """Angular momentum (3,) about a point, world axes."""
        pin.computeCentroidalMomentum(self.model, self.data, q, v)
        momentum = self.data.hg
        return momentum.angular + np.cross(self.data.com[0] - point, momentum.linear)

    def line_moment_and_inertia(self, state: FloatingState, side: str) -> tuple[float, float]:
        """Moment [N m] that a motion needs about the stance line, and inertia [kg m²] about it."""
        total = self.forces(state)
        pin.ccrba(self.model, self.data, state.q, state.v)
        pin.updateFramePlacement(self.model, self.data, self.sole(side))
        base, sole = self.data.oMi[1], self.data.oMf[self.sole(side)].translation
        force, moment = base.rotation @ total[:3], base.rotation @ total[3:6]
        arm, out = base.translation - sole, self.data.com[0] - sole
        about = moment[0] + arm[1] * force[2] - arm[2] * force[1]
        about_com = self.data.Ig
        inertia = about_com.inertia[0, 0] + about_com.mass * (out[1] ** 2 + out[2] ** 2)
        return float(about), float(inertia)

    def impulse(
        self, q: np.ndarray, before: np.ndarray, after: np.ndarray, side: str
    ) -> np.ndarray:
        """Impulses (11,) [N m s] at the joints and about the foot line that a jump needs.

        They vanish in a plastic impact: neither torques nor a line contact can be that fast.
        """
        jump = self.mass(q) @ (after - before)
        jacobian = self.jacobian(q, side)
        wrench = np.linalg.solve(jacobian[:, :6].T, jump[:6])
        return np.append(jump[6:] - jacobian[:, 6:].T @ wrench, wrench[3])
