"""The robot as a tree of bodies rooted at the stance foot, and its symbolic kinematics.

The stance foot lies flat along its line: its frame can only roll about the line (world x). The
tree runs from the stance (left) foot up to the base and down to the swing (right) foot; joints:
stance then swing, each ``hip_yaw, hip_roll, hip_pitch, knee, ankle``.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from slider.config.robot import VirtualKnee
from slider.gait.leg_map import LEG_JOINTS
from slider.robot.names import KNEE_JOINTS

NUM_JOINTS = len(KNEE_JOINTS)
STANCE, SWING = "stance", "swing"


@dataclass(frozen=True)
class Edge:
    """Joint from body ``parent`` to ``child`` of the rooted tree.

    ``sign`` is −1 where the tree runs against the joint (from the stance foot to the base);
    ``at_parent``, ``at_child``: the joint's place in the two body frames [m]. ``slides``: the joint
    moves the child along the axis instead of turning it.
    """

    parent: str
    child: str
    joint: int
    axis: int
    sign: float
    at_parent: np.ndarray
    at_child: np.ndarray
    slides: bool = False

    @property
    def unit(self) -> ca.DM:
        """The axis (3,)."""
        return ca.DM(np.eye(3)[self.axis])

    def place(self, q: ca.SX) -> ca.SX:
        """Where the joint has moved the child to, in the parent's frame (3,) [m]."""
        if not self.slides:
            return ca.SX(ca.DM(self.at_parent))
        return ca.DM(self.at_parent) + self.unit * (self.sign * q[self.joint])


@dataclass(frozen=True)
class BodyPose:
    """Rotation to world (3, 3), origin [m], angular velocity (body), linear velocity (world)."""

    rotation: ca.SX
    origin: ca.SX
    angular: ca.SX
    linear: ca.SX


def rotation(axis: int, angle: ca.SX) -> ca.SX:
    """Rotation matrix (3, 3) about a coordinate axis."""
    matrix = ca.SX(3, 3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[axis, axis] = 1
    matrix[i, i] = matrix[j, j] = ca.cos(angle)
    matrix[i, j], matrix[j, i] = -ca.sin(angle), ca.sin(angle)
    return matrix


# Bodies of a leg from the hip down: name, axis, its sign, place in the body above [m], slides.
LegChain = list[tuple[str, int, float, np.ndarray, bool]]


_ZERO = np.zeros(3)
_HIP: LegChain = [("yaw", 2, 1.0, _ZERO, False), ("roll", 0, 1.0, _ZERO, False)]


def knee_leg(knee: VirtualKnee) -> LegChain:
    """The knee bends about −y."""
    return [
        *_HIP,
        ("thigh", 1, 1.0, _ZERO, False),
        ("shank", 1, -1.0, np.array([0.0, 0.0, -knee.thigh_length]), False),
        ("foot", 1, 1.0, np.array([0.0, 0.0, -knee.shank_length]), False),
    ]


def prismatic_leg(leg_length: float) -> LegChain:
    """The slide lowers the tube along −z."""
    return [
        *_HIP,
        ("pitch", 1, 1.0, _ZERO, False),
        ("tube", 2, -1.0, _ZERO, True),
        ("foot", 1, 1.0, np.array([0.0, 0.0, -leg_length]), False),
    ]


def edges_of(hip_offset: float, chain: LegChain) -> list[Edge]:
    """From the stance foot up to the base and down to the swing foot."""
    edges: list[Edge] = []
    for side, sign in ((STANCE, 1.0), (SWING, -1.0)):
        parent, hip = "base", np.array([0.0, sign * hip_offset, 0.0])
        for k, (name, axis, turn, below, slides) in enumerate(chain):
            place, child = hip if k == 0 else below, f"{side}_{name}"
            if side == STANCE:
                edges.insert(0, Edge(child, parent, k, axis, -turn, _ZERO, place, slides))
            else:
                edges.append(Edge(parent, child, LEG_JOINTS + k, axis, turn, place, _ZERO, slides))
            parent = child
    return edges


def next_pose(pose: BodyPose, edge: Edge, q: ca.SX, v: ca.SX) -> BodyPose:
    """The child's pose of a parent's."""
    if edge.slides:
        place, rate = edge.place(q), edge.unit * (edge.sign * v[edge.joint])
        moved = pose.linear + pose.rotation @ (ca.cross(pose.angular, place) + rate)
        return BodyPose(pose.rotation, pose.origin + pose.rotation @ place, pose.angular, moved)
    turn = rotation(edge.axis, edge.sign * q[edge.joint])
    rot = pose.rotation @ turn
    angular = turn.T @ pose.angular + edge.unit * (edge.sign * v[edge.joint])
    at_parent, at_child = ca.DM(edge.at_parent), ca.DM(edge.at_child)
    origin = pose.origin + pose.rotation @ at_parent - rot @ at_child
    linear = pose.linear + pose.rotation @ ca.cross(pose.angular, at_parent)
    return BodyPose(rot, origin, angular, linear - rot @ ca.cross(angular, at_child))
