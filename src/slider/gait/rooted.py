"""The real robot rooted at the stance foot, in its own coordinates: M q̈ + h = B u.

q = (roll of the foot about its line, ten driven joints, stance leg first), reflected in right
stance. The ten joint efforts are the inputs, B = (0, I)ᵀ: no moment acts about the line.

Outputs have relative degree two, ÿ = L_f² y + L_g L_f y u with L_g L_f y = H' M⁻¹ B, H' the columns
of H for roll and joints. Input-output linearisation inverts this decoupling matrix. For joints as
outputs it is a principal block of M⁻¹, always regular; for absolute angles it can become singular.
"""

from functools import cached_property

import casadi as ca
import numpy as np

from slider.config.robot import Mechanism
from slider.gait.dynamics import OwnTree
from slider.gait.outputs import YAW, output_matrix
from slider.gait.tree import NUM_JOINTS, BodyPose
from slider.robot.names import GAIT_JOINTS
from slider.robot.transmission import Transmission

NUM = 1 + NUM_JOINTS  # coordinates
DECOUPLING = "decoupling"  # name of the array and of its residual


class RootedRobot:
    """Symbolic functions of q and q̇ (11,), the rotors and the damping of the joints included."""

    def __init__(self, robot: Mechanism) -> None:
        self.tree = OwnTree(robot)
        self.q, self.v, self._a = q, v, a = [ca.SX.sym(name, NUM) for name in "qva"]
        motion = self.tree.inverse_dynamics(q[0], v[0], a[0], q[1:], v[1:], a[1:])
        line_moment = self.tree.roll_wrench(q[0], motion)[1][0]
        self._forces = ca.vertcat(line_moment, motion.efforts)  # generalised (11,)

    def equation(self, row: int) -> tuple[ca.SX, ca.SX]:
        """One row of M (11,) and of h; row 0, the roll's, has no input."""
        force = self._forces[row]
        return ca.gradient(force, self._a), ca.substitute(force, self._a, ca.SX.zeros(NUM))

    @cached_property
    def dynamics(self) -> ca.Function:
        """(q, q̇) → M (11, 11), h (11,)."""
        bias = ca.substitute(self._forces, self._a, ca.SX.zeros(NUM))
        return ca.Function("dynamics", [self.q, self.v], [ca.jacobian(self._forces, self._a), bias])

    @property
    def center_of_mass(self) -> tuple[ca.SX, ca.SX]:
        """Position and velocity (3,) relative to the stance sole [m], [m/s]."""
        bodies, poses = self.tree.bodies, self.poses(self.q)
        total = sum(bodies[name].mass for name in poses)
        place = rate = ca.SX.zeros(3)
        for name, pose in poses.items():
            point, velocity = self.tree.point(pose, bodies[name].com)
            share = bodies[name].mass / total
            place, rate = place + share * point, rate + share * velocity
        return place, rate

    def poses(self, q: ca.SX) -> dict[str, BodyPose]:
        """Poses of all bodies at q (11,) with velocities q̇."""
        return self.tree.poses(q[0], self.v[0], q[1:], self.v[1:])


def decoupling(robot: Mechanism, q: np.ndarray) -> np.ndarray:
    """Least singular value [rad/s², m/s²] and condition number (S, 2) of L_g L_f y at q (S, 11).

    Inputs are the motors' torques as shares of their limits: the least singular value is the
    acceleration of the outputs that full torques produce in the worst direction.
    """
    rooted, motors = RootedRobot(robot), Transmission.of(robot)
    masses = rooted.dynamics.map(len(q))(q.T, np.zeros(q.T.shape))[0].full()
    mass = masses.reshape(q.shape[1], len(q), q.shape[1]).transpose(1, 0, 2)
    rows = np.delete(output_matrix(robot.geometry), YAW, axis=1)
    inputs = np.zeros((NUM, NUM_JOINTS))
    matrix = motors.matrix[:, GAIT_JOINTS]
    ours = matrix.any(axis=1)  # without the motors of the ankles' rolls
    inputs[1:] = matrix[ours].T * motors.torque[ours]
    values = np.linalg.svd(rows @ np.linalg.solve(mass, inputs[None]), compute_uv=False)
    with np.errstate(divide="ignore"):
        return np.stack([values[:, -1], values[:, 0] / values[:, -1]], axis=1)
