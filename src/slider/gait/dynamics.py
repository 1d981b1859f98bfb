"""Symbolic dynamics of the robot in the virtual knee's coordinates, rooted at the stance foot.

The recursive Newton-Euler pass follows Featherstone, *Rigid Body Dynamics Algorithms* (2008),
chapter 5, in body frames. The bodies are those of the prismatic leg (``PrismaticTree``: eq. 1 is a
change of coordinates, and the dynamics are the real leg's, rotors included), or of the virtual knee
(``StanceTree``).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

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

# Of a body, in its frame: angular velocity, angular and (minus gravity) linear acceleration.
Motion = tuple[ca.SX, ca.SX, ca.SX]


@dataclass(frozen=True)
class InverseDynamics:
    """Efforts and foot wrench of a motion.

    Attributes:
        torques: of the virtual knee's joints (10,) [N m].
        efforts: of the prismatic legs' joints, equivalent by virtual work (10,) [N m, N].
        force, moment: on the stance foot at its origin [N], [N m].
        swing_roll: effort of the swing ankle's roll, where there is one (1,) [N m].
    """

    torques: ca.SX
    efforts: ca.SX
    force: ca.SX
    moment: ca.SX
    swing_roll: ca.SX = field(default_factory=lambda: ca.SX(0, 1))


class StanceTree:
    """The virtual-knee robot standing on its left foot."""

    def __init__(self, robot: Mechanism) -> None:
        self.map = LegMap.of(robot)
        self.roll_inertia = self.roll_damping = 0.0  # of the ankle's roll
        self.upper_link = "pitch"  # the leg is the line from its origin to the ankle
        self.bodies, self.edges = self._tree(robot)
        self.ground = "foot" if robot.geometry.sole is None else "sole"  # the body on the ground
        self.axis = robot.geometry.ankle_roll  # a point on the leg's roll axis, foot frame [m]
        down = np.array([0.0, 0.0, -robot.geometry.ankle_height])
        self.sole = down if self.ground == "foot" else down - self.axis  # in the ground body's
        self._rise = ca.sparsify(ca.DM(self.axis - down))  # of the roll axis above the ground

    def _tree(self, robot: Mechanism) -> tuple[dict[str, Body], list[Edge]]:
        axes, knee = robot.geometry.axes, robot.sliding_leg
        legs = (knee_leg(axes, knee, lateral) for lateral in (1.0, -1.0))
        return _both_legs(knee_bodies(robot)), edges_of(*legs)

    def foot_pose(self, roll: ca.SX, roll_rate: ca.SX) -> BodyPose:
        """Pose of the stance foot, or talus; the world's origin is the middle of line or sole."""
        r = rotation(0, roll)
        angular = ca.vertcat(roll_rate, 0, 0)
        up = -ca.DM(self.axis)
        return BodyPose(r, self._rise + r @ up, angular, r @ ca.cross(angular, up))

    def poses(self, roll: ca.SX, roll_rate: ca.SX, q: ca.SX, v: ca.SX) -> dict[str, BodyPose]:
        """Poses and velocities of all bodies."""
        q, v = self.all_joints(roll, q, (roll_rate, v))
        poses = {"stance_foot": self.foot_pose(roll, roll_rate)}
        if self.ground == "sole":
            still = ca.SX.zeros(3)
            poses["stance_sole"] = BodyPose(ca.SX.eye(3), self._rise + still, still, still)
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
        up = -ca.DM(self.axis)
        angular = ca.vertcat(roll_rate, 0, 0)
        turning = ca.vertcat(roll_acceleration, 0, 0)
        linear = ca.cross(turning, up) + ca.cross(angular, ca.cross(angular, up))
        linear += rotation(0, roll).T @ ca.DM([0, 0, names.GRAVITY])
        joints = self.all_joints(roll, q, (roll_rate, v), (roll_acceleration, a))
        return self.newton_euler((angular, turning, linear), *joints)

    def all_joints(self, roll: ca.SX, q: ca.SX, *rates: tuple[ca.SX, ca.SX]) -> tuple[ca.SX, ...]:
        """Positions, velocities and accelerations with the swing ankle's roll, where it has one.

        That roll keeps the sole level. ``rates`` are those of roll and joints (10,).
        """
        if self.ground == "foot":
            return q, *(joints for _, joints in rates)
        states = [ca.vertcat(*pair) for pair in ((roll, q), *rates)]
        level = self._levels(*states, *[ca.SX.zeros(1 + NUM_JOINTS)] * (2 - len(rates)))
        joints = [state[1:] for state in states]
        return tuple(ca.vertcat(*pair) for pair in zip(joints, level, strict=False))

    @cached_property
    def _levels(self) -> ca.Function:
        """Angle of the swing ankle's roll and its derivatives, from those of roll and joints."""
        x, rate, turn = (ca.SX.sym(name, 1 + NUM_JOINTS) for name in ("x", "rate", "turn"))
        pose, zero = self.foot_pose(x[0], ca.SX(0)), ca.SX.zeros(NUM_JOINTS)
        for edge in self.edges[:-1]:
            pose = next_pose(pose, edge, x[1:], zero)
        angle = -ca.atan2(pose.rotation[2, 1], pose.rotation[2, 2])
        first = ca.jtimes(angle, x, rate)
        second = ca.jtimes(angle, x, turn) + ca.jtimes(first, x, rate)
        return ca.Function("levels", [x, rate, turn], [angle, first, second])

    def newton_euler(self, foot: Motion, q: ca.SX, v: ca.SX, a: ca.SX) -> InverseDynamics:
        """Recursive Newton-Euler pass from the stance foot's motion in its own frame.

        ``q``, ``v``, ``a``: joint positions, velocities, accelerations (10,).
        """
        torques, force, moment = _pass(self.edges, self.bodies, foot, q, v, a)
        return InverseDynamics(torques, self.map.efforts(q, torques), force, moment)

    def roll_wrench(self, roll: ca.SX, dynamics: InverseDynamics) -> tuple[ca.SX, ca.SX]:
        """Force on the leg, and moment about a point on its roll axis, world axes."""
        r = rotation(0, roll)
        moment = dynamics.moment - ca.cross(ca.DM(self.axis), dynamics.force)
        return r @ dynamics.force, r @ moment

    def roll_impulse(
        self, jump: InverseDynamics, before: Sequence[ca.SX], after: Sequence[ca.SX]
    ) -> ca.SX:
        """Impulse [N m s] about the landing leg's roll axis, with its ankle's rotor.

        ``before`` and ``after``: roll, its rate, joints and rates; ``after`` is reflected.
        """
        moment = self.roll_wrench(after[0], jump)[1][0]
        if self.ground == "foot":
            return moment
        roll, rate, q, v = before
        landing = self.all_joints(roll, q, (rate, v))[1][NUM_JOINTS]
        return moment + self.roll_inertia * (after[1] - landing)

    def ground_wrench(
        self, roll: ca.SX, dynamics: InverseDynamics, sole: Motion | None = None
    ) -> tuple[ca.SX, ca.SX]:
        """Ground force and moment at the middle of line or sole, world axes.

        ``sole`` is the motion of the sole on the ground, by default at rest under gravity.
        """
        force, moment = self.roll_wrench(roll, dynamics)
        if self.ground == "sole":
            still = ca.SX.zeros(3)
            motion = sole or (still, still, ca.SX([0, 0, names.GRAVITY]))
            own_force, own_moment = _inertial_wrench(self.bodies[f"{STANCE}_sole"], *motion)
            force, moment = force + own_force, moment + own_moment
        return force, moment + ca.cross(self._rise, force)


class OwnTree(StanceTree):
    """The real robot standing on its left foot, in the coordinates of its own joints."""

    def __init__(self, robot: Mechanism) -> None:
        super().__init__(robot)
        if robot.geometry.knee is None:
            self.upper_link = "tube"
        *damping, last = [robot.joints[name].damping for name in robot.geometry.leg_joints]
        inertia = leg_inertia(robot)
        legs = ca.DM(np.kron(np.eye(2), inertia[:LEG_JOINTS, :LEG_JOINTS]))
        self._inertia, self._damping = legs, ca.DM(np.tile(damping, 2))
        if self.ground == "sole":
            self.roll_inertia, self.roll_damping = inertia[-1, -1], last
            self._inertia = ca.diagcat(legs, self.roll_inertia)
            self._damping = ca.vertcat(self._damping, last)

    def _tree(self, robot: Mechanism) -> tuple[dict[str, Body], list[Edge]]:
        legs = (robot.geometry.leg(lateral) for lateral in (1.0, -1.0))
        edges = edges_of(*legs)
        if robot.geometry.sole is not None:
            axis, place = np.eye(3)[0], robot.geometry.ankle_roll
            edges.append(Edge(f"{SWING}_foot", f"{SWING}_sole", NUM_JOINTS, axis, place, 0 * place))
        return _both_legs(own_bodies(robot)), edges

    def newton_euler(self, foot: Motion, q: ca.SX, v: ca.SX, a: ca.SX) -> InverseDynamics:
        """As :meth:`StanceTree.newton_euler`, for the prismatic legs with rotors and damping."""
        efforts, force, moment = _pass(self.edges, self.bodies, foot, q, v, a)
        efforts += self._inertia @ a + self._damping * v
        driven = efforts[:NUM_JOINTS]
        return InverseDynamics(driven, driven, force, moment, efforts[NUM_JOINTS:])


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
    """Joint efforts (10,), force and moment on the stance foot that produce a motion."""
    motion = {f"{STANCE}_foot": foot}
    frames: dict[str, ca.SX] = {}
    for edge in edges:
        frames[edge.child], motion[edge.child] = _next_motion(motion[edge.parent], edge, q, v, a)
    wrench = {n: _inertial_wrench(bodies[n], *motion[n]) for n in motion}
    efforts: list[ca.SX] = [ca.SX(0)] * len(edges)
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
