"""Symbolic dynamics of the robot in the virtual knee's coordinates, rooted at the stance foot.

The recursive Newton-Euler pass follows Featherstone, *Rigid Body Dynamics Algorithms* (2008),
chapter 5, in body frames. Bodies move as the prismatic leg's do (``PrismaticTree``: eq. 1 is a
change of coordinates, and the dynamics are the real leg's, rotors included), or as the virtual
knee's (``StanceTree``).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from slider.config.robot import Mechanism
from slider.gait.tree import (
    LEG_JOINTS,
    NUM_JOINTS,
    STANCE,
    SWING,
    BodyPose,
    Edge,
    LegMap,
    edges_of,
    knee_leg,
    next_pose,
    rotation,
)
from slider.robot import names
from slider.robot.bodies import Body, knee_bodies, own_bodies
from slider.robot.transmission import leg_inertia

# Of a body in its own frame: angular velocity, angular acceleration, the origin's less gravity.
Motion = tuple[ca.SX, ca.SX, ca.SX]


@dataclass(frozen=True)
class InverseDynamics:
    """Efforts and foot wrench of a motion.

    Attributes:
        torques: of the virtual knee's joints (10,) [N m].
        efforts: of the prismatic legs' joints, the same work (10,) [N m, N].
        force, moment: on the stance foot at its origin [N], [N m].
    """

    torques: ca.SX
    efforts: ca.SX
    force: ca.SX
    moment: ca.SX


class StanceTree:
    """The virtual-knee robot standing on its left foot."""

    def __init__(self, robot: Mechanism) -> None:
        self.map = LegMap.of(robot)
        self.upper_link = "pitch"  # from which the line to the ankle is the leg
        self.bodies, self.edges = self._tree(robot)
        self.sole = np.array([0.0, 0.0, -robot.geometry.ankle_height])  # in the foot's frame [m]

    def _tree(self, robot: Mechanism) -> tuple[dict[str, Body], list[Edge]]:
        axes, knee = robot.geometry.axes, robot.sliding_leg
        legs = (knee_leg(axes, knee, lateral) for lateral in (1.0, -1.0))
        return _both_legs(knee_bodies(robot)), edges_of(*legs)

    def foot_pose(self, roll: ca.SX, roll_rate: ca.SX) -> BodyPose:
        """The stance foot; the middle of its line is the world's origin."""
        r = rotation(0, roll)
        angular = ca.vertcat(roll_rate, 0, 0)
        up = -ca.DM(self.sole)
        return BodyPose(r, r @ up, angular, r @ ca.cross(angular, up))

    def poses(self, roll: ca.SX, roll_rate: ca.SX, q: ca.SX, v: ca.SX) -> dict[str, BodyPose]:
        """Poses and velocities of all bodies."""
        poses = {"stance_foot": self.foot_pose(roll, roll_rate)}
        for edge in self.edges:
            poses[edge.child] = next_pose(poses[edge.parent], edge, q, v)
        return poses

    def point(self, pose: BodyPose, local: np.ndarray) -> tuple[ca.SX, ca.SX]:
        """World position and velocity of a point fixed in a body."""
        p = ca.DM(local)
        return pose.origin + pose.rotation @ p, pose.linear + pose.rotation @ ca.cross(
            pose.angular, p
        )

    def inverse_dynamics(
        self, roll: ca.SX, roll_rate: ca.SX, roll_acceleration: ca.SX, q: ca.SX, v: ca.SX, a: ca.SX
    ) -> InverseDynamics:
        """Torques and foot wrench of a motion under gravity."""
        up = -ca.DM(self.sole)
        angular = ca.vertcat(roll_rate, 0, 0)
        turning = ca.vertcat(roll_acceleration, 0, 0)
        linear = ca.cross(turning, up) + ca.cross(angular, ca.cross(angular, up))
        linear += rotation(0, roll).T @ ca.DM([0, 0, names.GRAVITY])
        return self.newton_euler((angular, turning, linear), q, v, a)

    def newton_euler(self, foot: Motion, q: ca.SX, v: ca.SX, a: ca.SX) -> InverseDynamics:
        """Recursive Newton-Euler pass from the stance foot's motion in its own frame.

        ``q``, ``v``, ``a``: joint positions, velocities, accelerations (10,).
        """
        torques, force, moment = _pass(self.edges, self.bodies, foot, q, v, a)
        return InverseDynamics(torques, self.map.efforts(q, torques), force, moment)

    def line_wrench(self, roll: ca.SX, dynamics: InverseDynamics) -> tuple[ca.SX, ca.SX]:
        """Ground force and moment at the middle of the foot line, world axes."""
        r = rotation(0, roll)
        moment = dynamics.moment - ca.cross(ca.DM(self.sole), dynamics.force)
        return r @ dynamics.force, r @ moment


class OwnTree(StanceTree):
    """The real robot standing on its left foot, in the coordinates of its own joints."""

    def __init__(self, robot: Mechanism) -> None:
        super().__init__(robot)
        if robot.geometry.knee is None:
            self.upper_link = "tube"
        damping = [robot.joints[name].damping for name in robot.geometry.leg_joints[:LEG_JOINTS]]
        self._inertia = ca.DM(np.kron(np.eye(2), leg_inertia(robot)))
        self._damping = ca.DM(np.tile(damping, 2))

    def _tree(self, robot: Mechanism) -> tuple[dict[str, Body], list[Edge]]:
        legs = (robot.geometry.leg(lateral) for lateral in (1.0, -1.0))
        return _both_legs(own_bodies(robot)), edges_of(*legs)

    def newton_euler(self, foot: Motion, q: ca.SX, v: ca.SX, a: ca.SX) -> InverseDynamics:
        """As :meth:`StanceTree.newton_euler`, for the prismatic legs, their rotors and friction."""
        efforts, force, moment = _pass(self.edges, self.bodies, foot, q, v, a)
        efforts += self._inertia @ a + self._damping * v
        return InverseDynamics(efforts, efforts, force, moment)


class PrismaticTree(StanceTree):
    """The real robot standing on its left foot, its motion given in the knee's coordinates."""

    def __init__(self, robot: Mechanism) -> None:
        super().__init__(robot)
        self._slides = OwnTree(robot)

    def newton_euler(self, foot: Motion, q: ca.SX, v: ca.SX, a: ca.SX) -> InverseDynamics:
        """As :meth:`OwnTree.newton_euler`; torques are the virtual knee's."""
        place, rate = self.map.positions(q), self.map.velocities(q, v)
        turn = self.map.accelerations(q, v, a)
        dynamics = self._slides.newton_euler(foot, place, rate, turn)
        return replace(dynamics, torques=self.map.knee_torques(q, dynamics.efforts))


def _both_legs(bodies: Mapping[str, Body]) -> dict[str, Body]:
    """Bodies by their names in the tree: the stance leg is the left one."""
    tree = {"base": bodies["base"]}
    for name, body in bodies.items():
        if name != "base":
            tree |= {f"{STANCE}_{name}": body, f"{SWING}_{name}": body.reflected}
    return tree


def _pass(
    edges: list[Edge], bodies: Mapping[str, Body], foot: Motion, q: ca.SX, v: ca.SX, a: ca.SX
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Joint efforts (10,), force and moment on the stance foot of a motion."""
    motion = {f"{STANCE}_foot": foot}
    frames: dict[str, ca.SX] = {}
    for edge in edges:
        frames[edge.child], motion[edge.child] = _next_motion(motion[edge.parent], edge, q, v, a)
    wrench = {n: _inertial_wrench(bodies[n], *motion[n]) for n in motion}
    efforts: list[ca.SX] = [ca.SX(0)] * NUM_JOINTS
    for edge in reversed(edges):
        force, moment = wrench[edge.child]
        moment = moment - ca.cross(ca.DM(edge.at_child), force)
        efforts[edge.joint] = ca.dot(edge.unit, force if edge.slides else moment)
        force, moment = frames[edge.child] @ force, frames[edge.child] @ moment
        own_force, own_moment = wrench[edge.parent]
        moment = moment + ca.cross(edge.place(q), force)
        wrench[edge.parent] = (own_force + force, own_moment + moment)
    return ca.vertcat(*efforts), *wrench[f"{STANCE}_foot"]


def _next_motion(motion: Motion, edge: Edge, q: ca.SX, v: ca.SX, a: ca.SX) -> tuple[ca.SX, Motion]:
    """Rotation and motion of an edge's child, from its parent's motion."""
    angular, turning, linear = motion
    if edge.slides:
        place, along = edge.place(q), edge.unit
        moved = ca.cross(turning, place) + ca.cross(angular, ca.cross(angular, place))
        moved += 2 * ca.cross(angular, along * v[edge.joint]) + along * a[edge.joint]
        return ca.SX.eye(3), (angular, turning, linear + moved)
    turn = edge.rotation(q)
    rate, carried = edge.unit * v[edge.joint], turn.T @ angular
    new_angular = carried + rate
    new_turning = turn.T @ turning + edge.unit * a[edge.joint]
    new_turning += ca.cross(carried, rate)
    at_joint = turn.T @ (linear + _relative(angular, turning, edge.at_parent))
    return turn, (
        new_angular,
        new_turning,
        at_joint - _relative(new_angular, new_turning, edge.at_child),
    )


def _relative(angular: ca.SX, turning: ca.SX, place: np.ndarray) -> ca.SX:
    """Acceleration of a body-fixed point relative to the frame's origin."""
    if not np.any(place):
        return ca.SX.zeros(3)
    p = ca.DM(place)
    return ca.cross(turning, p) + ca.cross(angular, ca.cross(angular, p))


def _inertial_wrench(
    body: Body, angular: ca.SX, turning: ca.SX, linear: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """Force and moment about the frame's origin that produce a body's motion."""
    inertia = ca.sparsify(ca.DM(body.inertia))
    force = body.mass * (linear + _relative(angular, turning, body.com))
    moment = inertia @ turning + ca.cross(angular, inertia @ angular)
    return force, moment + ca.cross(ca.DM(body.com), force)
