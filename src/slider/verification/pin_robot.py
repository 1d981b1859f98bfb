"""The virtual-knee robot as a floating-base pinocchio model: an independent dynamics."""

# pinocchio lies below cmeel.prefix, where pyright does not look.
# pyright: reportMissingImports=false

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from slider.robot.knee_model import LEG_BODIES, Body, KneeModel
from slider.robot.names import SIDES

AXES = {"yaw": [0, 0, 1], "roll": [1, 0, 0], "thigh": [0, 1, 0], "shank": [0, -1, 0]}
AXES["foot"] = [0, 1, 0]
WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


@dataclass(frozen=True)
class FloatingState:
    """Configuration, velocity and acceleration of the floating-base model."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


class PinRobot:
    """Frames ``left_sole`` and ``right_sole`` are the middles of the foot lines."""

    def __init__(self, knee: KneeModel) -> None:
        self.model = pin.Model()
        root = self.model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
        self._append(root, knee.bodies["base"])
        down = {"shank": [0, 0, -knee.thigh], "foot": [0, 0, -knee.shank]}
        for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
            parent = root
            for name in LEG_BODIES:
                place = [0, sign * knee.hip_offset, 0] if name == "yaw" else down.get(name, [0] * 3)
                parent = self.model.addJoint(
                    parent,
                    pin.JointModelRevoluteUnaligned(np.array(AXES[name], dtype=float)),
                    pin.SE3(np.eye(3), np.array(place, dtype=float)),
                    f"{side}_{name}",
                )
                self._append(parent, knee.bodies[name])
            sole = pin.SE3(np.eye(3), np.array([0, 0, -knee.ankle_height]))
            self.model.addFrame(pin.Frame(f"{side}_sole", parent, 0, sole, pin.FrameType.OP_FRAME))
        self.ends = np.array([[knee.toe, 0.0, 0.0], [-knee.heel, 0.0, 0.0]])
        self.data = self.model.createData()
        self.mass_total = pin.computeTotalMass(self.model)

    def _append(self, joint: int, body: Body) -> None:
        inertia = pin.Inertia(body.mass, body.com, np.diag(body.inertia))
        self.model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())

    def sole(self, side: str) -> int:
        """Frame of a sole."""
        return self.model.getFrameId(f"{side}_sole")

    def sole_place(self, q: np.ndarray, side: str) -> np.ndarray:
        """Middle (3,) of a foot line [m]."""
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.sole(side)].translation.copy()

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
        return pin.rnea(self.model, self.data, state.q, state.v, state.a)

    def difference(self, expected: np.ndarray, found: np.ndarray) -> np.ndarray:
        """Way (16,) from one configuration to another: base [m, rad], then joints [rad]."""
        return pin.difference(self.model, expected, found)

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
        """Joint torques (10,) and ground force and moment (6,) at the stance sole."""
        total = self.forces(state)
        jacobian = self.jacobian(state.q, side)
        wrench = np.linalg.solve(jacobian[:, :6].T, total[:6])
        return total[6:] - jacobian[:, 6:].T @ wrench, wrench

    def mass(self, q: np.ndarray) -> np.ndarray:
        """Joint-space inertia (16, 16)."""
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
