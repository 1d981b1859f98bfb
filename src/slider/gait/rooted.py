"""The real robot rooted at the stance foot, in its own coordinates: M q̈ + h = B u.

q = (roll of the foot about its line, ten driven joints, stance leg first), reflected in right
stance. The ten joint efforts are the inputs, B = (0, I)ᵀ: no moment acts about the line.
"""

from functools import cached_property

import casadi as ca
import numpy as np

from slider.config.robot import Mechanism
from slider.gait.dynamics import SlideTree
from slider.gait.tree import NUM_JOINTS, BodyPose
from slider.robot.knee_model import build_knee_model
from slider.robot.prismatic_model import build_prismatic_model

NUM = 1 + NUM_JOINTS  # coordinates


class RootedRobot:
    """Symbolic functions of q and q̇ (11,), the rotors and the damping of the joints included."""

    def __init__(self, robot: Mechanism) -> None:
        knee = build_knee_model(robot.geometry, robot.links, robot.virtual_knee)
        self.tree = SlideTree(knee, robot.geometry.leg_length, build_prismatic_model(robot))
        self.sole = np.array([0.0, 0.0, -knee.ankle_height])
        self.q, self.v, self._a = (ca.SX.sym(name, NUM) for name in "qva")

    @cached_property
    def _forces(self) -> ca.SX:
        """Generalised forces (11,) of accelerations."""
        q, v, a = self.q, self.v, self._a
        found = self.tree.inverse_dynamics(q[0], v[0], a[0], q[1:], v[1:], a[1:])
        return ca.vertcat(self.tree.line_wrench(q[0], found)[1][0], found.efforts)

    @cached_property
    def mass(self) -> ca.SX:
        """M(q) (11, 11)."""
        return ca.jacobian(self._forces, self._a)

    @cached_property
    def bias(self) -> ca.SX:
        """h(q, q̇) (11,)."""
        return ca.substitute(self._forces, self._a, ca.SX.zeros(NUM))

    @cached_property
    def dynamics(self) -> ca.Function:
        """(q, q̇) → M, h."""
        return ca.Function("dynamics", [self.q, self.v], [self.mass, self.bias])

    def equation(self, row: int) -> tuple[ca.SX, ca.SX]:
        """A row of M (11,) and of h, for less than all: that of the roll, 0, has no input."""
        force = self._forces[row]
        return ca.gradient(force, self._a), ca.substitute(force, self._a, ca.SX.zeros(NUM))

    @cached_property
    def center_of_mass(self) -> tuple[ca.SX, ca.SX]:
        """Position and velocity (3,) relative to the stance sole [m], [m/s]."""
        bodies, poses = self.tree.leg.bodies, self.poses(self.q)
        masses = {name: bodies[name.rsplit("_", 1)[-1]] for name in poses}
        total = sum(body.mass for body in masses.values())
        points = {name: self.tree.point(poses[name], body.com) for name, body in masses.items()}
        place, rate = (
            sum((masses[name].mass / total * points[name][k] for name in poses), ca.SX.zeros(3))
            for k in range(2)
        )
        return place, rate

    def poses(self, q: ca.SX) -> dict[str, BodyPose]:
        """Poses of all bodies at q (11,) with velocities q̇."""
        return self.tree.poses(q[0], self.v[0], q[1:], self.v[1:])
