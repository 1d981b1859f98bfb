"""The virtual-knee robot as a floating-base pinocchio model: an independent dynamics."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from slider.robot.knee_model import LEG_BODIES, Body, KneeModel

SIDES = ("left", "right")
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
        self.data = self.model.createData()

    def _append(self, joint: int, body: Body) -> None:
        inertia = pin.Inertia(body.mass, body.com, np.diag(body.inertia))
        self.model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())

    def sole(self, side: str) -> int:
        return self.model.getFrameId(f"{side}_sole")

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
        total = pin.rnea(self.model, self.data, state.q, state.v, state.a)
        jacobian = self.jacobian(state.q, side)
        wrench = np.linalg.solve(jacobian[:, :6].T, total[:6])
        return total[6:] - jacobian[:, 6:].T @ wrench, wrench

    def impact(self, q: np.ndarray, v: np.ndarray, side: str) -> np.ndarray:
        """Velocity (16,) after a plastic impact: the sole stops but for the rate about x."""
        mass = pin.crba(self.model, self.data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        held = self.jacobian(q, side)[[0, 1, 2, 4, 5]]
        system = np.block([[mass, -held.T], [held, np.zeros((5, 5))]])
        return np.linalg.solve(system, np.concatenate([mass @ v, np.zeros(5)]))[:16]

    def momentum_about(self, q: np.ndarray, v: np.ndarray, point: np.ndarray) -> np.ndarray:
        """Angular momentum (3,) about a point, world axes."""
        pin.computeCentroidalMomentum(self.model, self.data, q, v)
        momentum = self.data.hg
        return momentum.angular + np.cross(self.data.com[0] - point, momentum.linear)
