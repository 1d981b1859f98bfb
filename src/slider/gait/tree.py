"""Symbolic kinematics and dynamics of the virtual-knee robot, rooted at the stance foot.

The stance foot lies flat along its line: its frame can only roll about the line (world x). The
tree runs from the stance (left) foot up to the base and down to the swing (right) foot; joints:
stance then swing, each ``hip_yaw, hip_roll, hip_pitch, knee, ankle``. The recursive Newton-Euler
pass follows Featherstone, *Rigid Body Dynamics Algorithms* (2008), chapter 5, in body frames.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from slider.robot.knee_model import LEG_BODIES, Body, KneeModel

GRAVITY = 9.81  # [m/s²]
NUM_JOINTS = 10
LEG_JOINTS = 5
STANCE, SWING = "stance", "swing"
# Axis and its sign per leg joint: the knee turns about −y.
_AXES = ((2, 1.0), (0, 1.0), (1, 1.0), (1, -1.0), (1, 1.0))
# Reflection at the sagittal plane: yaw and roll flip.
LEG_MIRROR = np.array([-1.0, -1.0, 1.0, 1.0, 1.0])


@dataclass(frozen=True)
class Edge:
    """Joint from body ``parent`` to ``child`` of the rooted tree.

    ``sign`` is −1 where the tree runs against the joint (from the stance foot to the base);
    ``at_parent``, ``at_child``: the joint's place in the two body frames [m].
    """

    parent: str
    child: str
    joint: int
    axis: int
    sign: float
    at_parent: np.ndarray
    at_child: np.ndarray


@dataclass(frozen=True)
class BodyPose:
    """Rotation to world (3, 3), origin [m], angular velocity (body), linear velocity (world)."""

    rotation: ca.SX
    origin: ca.SX
    angular: ca.SX
    linear: ca.SX


@dataclass(frozen=True)
class InverseDynamics:
    """Joint torques (10,) [N m]; force [N] and moment [N m] on the stance foot at its origin."""

    torques: ca.SX
    force: ca.SX
    moment: ca.SX


def rotation(axis: int, angle: ca.SX) -> ca.SX:
    """Rotation matrix (3, 3) about a coordinate axis."""
    matrix = ca.SX(3, 3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[axis, axis] = 1
    matrix[i, i] = matrix[j, j] = ca.cos(angle)
    matrix[i, j], matrix[j, i] = -ca.sin(angle), ca.sin(angle)
    return matrix


def _vector(values: np.ndarray) -> ca.DM:
    return ca.DM(np.asarray(values, dtype=float))


class StanceTree:
    """The robot standing on its left foot."""

    def __init__(self, model: KneeModel) -> None:
        self.model = model
        self.edges = _edges(model)
        self._sole = np.array([0.0, 0.0, -model.ankle_height])

    def body(self, name: str) -> Body:
        """Inertial data of a body such as ``stance_thigh`` or ``base``."""
        return self.model.bodies[name.rsplit("_", 1)[-1]]

    def foot_pose(self, roll: ca.SX, roll_rate: ca.SX) -> BodyPose:
        """The stance foot; the middle of its line is the world's origin."""
        r = rotation(0, roll)
        angular = ca.vertcat(roll_rate, 0, 0)
        up = -_vector(self._sole)
        return BodyPose(r, r @ up, angular, r @ ca.cross(angular, up))

    def poses(self, roll: ca.SX, roll_rate: ca.SX, q: ca.SX, v: ca.SX) -> dict[str, BodyPose]:
        """Poses and velocities of all bodies."""
        poses = {"stance_foot": self.foot_pose(roll, roll_rate)}
        for edge in self.edges:
            poses[edge.child] = _next_pose(poses[edge.parent], edge, q, v)
        return poses

    def point(self, pose: BodyPose, local: np.ndarray) -> tuple[ca.SX, ca.SX]:
        """World position and velocity of a point fixed in a body."""
        p = _vector(local)
        return pose.origin + pose.rotation @ p, pose.linear + pose.rotation @ ca.cross(
            pose.angular, p
        )

    def inverse_dynamics(
        self, roll: ca.SX, roll_rate: ca.SX, roll_acceleration: ca.SX, q: ca.SX, v: ca.SX, a: ca.SX
    ) -> InverseDynamics:
        """Torques and foot wrench of a motion under gravity."""
        up = -_vector(self._sole)
        angular = ca.vertcat(roll_rate, 0, 0)
        turning = ca.vertcat(roll_acceleration, 0, 0)
        linear = ca.cross(turning, up) + ca.cross(angular, ca.cross(angular, up))
        linear += rotation(0, roll).T @ ca.DM([0, 0, GRAVITY])
        return self.newton_euler(angular, turning, linear, q, v, a)

    def newton_euler(
        self, angular: ca.SX, turning: ca.SX, linear: ca.SX, q: ca.SX, v: ca.SX, a: ca.SX
    ) -> InverseDynamics:
        """Recursive Newton-Euler pass from the stance foot's motion (in its own frame).

        Args:
            angular, turning: angular velocity and acceleration of the foot.
            linear: acceleration of the foot's origin minus gravity.
            q, v, a: joint positions, velocities, accelerations (10,).
        """
        motion = {"stance_foot": (angular, turning, linear)}
        frames: dict[str, ca.SX] = {}
        for edge in self.edges:
            frames[edge.child], motion[edge.child] = _next_motion(
                motion[edge.parent], edge, q, v, a
            )
        wrench = {name: _inertial_wrench(self.body(name), *motion[name]) for name in motion}
        torques: list[ca.SX] = [ca.SX(0)] * NUM_JOINTS
        for edge in reversed(self.edges):
            force, moment = wrench[edge.child]
            moment = moment - ca.cross(_vector(edge.at_child), force)
            torques[edge.joint] = edge.sign * moment[edge.axis]
            force, moment = frames[edge.child] @ force, frames[edge.child] @ moment
            own_force, own_moment = wrench[edge.parent]
            moment = moment + ca.cross(_vector(edge.at_parent), force)
            wrench[edge.parent] = (own_force + force, own_moment + moment)
        return InverseDynamics(ca.vertcat(*torques), *wrench["stance_foot"])

    def line_wrench(self, roll: ca.SX, dynamics: InverseDynamics) -> tuple[ca.SX, ca.SX]:
        """Ground force and moment at the middle of the foot line, world axes."""
        r = rotation(0, roll)
        moment = dynamics.moment - ca.cross(_vector(self._sole), dynamics.force)
        return r @ dynamics.force, r @ moment


def _edges(model: KneeModel) -> list[Edge]:
    zero = np.zeros(3)
    down = {"shank": np.array([0, 0, -model.thigh]), "foot": np.array([0, 0, -model.shank])}
    edges = []
    for side, sign in ((STANCE, 1.0), (SWING, -1.0)):
        hip = np.array([0.0, sign * model.hip_offset, 0.0])
        leg = []
        parent = "base"
        for k, name in enumerate(LEG_BODIES):
            place = hip if k == 0 else down.get(name, zero)
            axis, turn = _AXES[k]
            leg.append((parent, f"{side}_{name}", k, axis, turn, place))
            parent = f"{side}_{name}"
        if side == STANCE:
            edges += [
                Edge(child, parent, k, axis, -turn, zero, place)
                for parent, child, k, axis, turn, place in reversed(leg)
            ]
        else:
            edges += [
                Edge(parent, child, LEG_JOINTS + k, axis, turn, place, zero)
                for parent, child, k, axis, turn, place in leg
            ]
    return edges


def _unit(axis: int) -> ca.DM:
    return ca.DM(np.eye(3)[axis])


def _next_pose(pose: BodyPose, edge: Edge, q: ca.SX, v: ca.SX) -> BodyPose:
    turn = rotation(edge.axis, edge.sign * q[edge.joint])
    rot = pose.rotation @ turn
    angular = turn.T @ pose.angular + _unit(edge.axis) * (edge.sign * v[edge.joint])
    at_parent, at_child = _vector(edge.at_parent), _vector(edge.at_child)
    origin = pose.origin + pose.rotation @ at_parent - rot @ at_child
    linear = pose.linear + pose.rotation @ ca.cross(pose.angular, at_parent)
    return BodyPose(rot, origin, angular, linear - rot @ ca.cross(angular, at_child))


Motion = tuple[ca.SX, ca.SX, ca.SX]


def _next_motion(motion: Motion, edge: Edge, q: ca.SX, v: ca.SX, a: ca.SX) -> tuple[ca.SX, Motion]:
    angular, turning, linear = motion
    turn = rotation(edge.axis, edge.sign * q[edge.joint])
    rate = _unit(edge.axis) * (edge.sign * v[edge.joint])
    carried = turn.T @ angular
    new_angular = carried + rate
    new_turning = turn.T @ turning + _unit(edge.axis) * (edge.sign * a[edge.joint])
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
    p = _vector(place)
    return ca.cross(turning, p) + ca.cross(angular, ca.cross(angular, p))


def _inertial_wrench(
    body: Body, angular: ca.SX, turning: ca.SX, linear: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """Force and moment about the frame's origin that produce a body's motion."""
    inertia = ca.diag(_vector(body.inertia))
    force = body.mass * (linear + _relative(angular, turning, body.com))
    moment = inertia @ turning + ca.cross(angular, inertia @ angular)
    return force, moment + ca.cross(_vector(body.com), force)
