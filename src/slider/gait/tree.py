"""The robot as a tree of bodies rooted at the stance foot, and its symbolic kinematics.

The stance foot lies flat along its line: its frame can only roll about the line (world x). The
tree runs from the stance (left) foot up to the base and down to the swing (right) foot; joints:
stance then swing, each three of the hip (``robot.geometry.axes.order``), knee, ankle.

Eq. 1 (exact) maps the virtual knee's coordinates to the slide's: q_p = φ(q_k), q̇_p = J q̇_k,
q̈_p = J q̈_k + J̇ q̇_k, and by virtual work τ_k = Jᵀ τ_p.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps

import casadi as ca
import numpy as np

from slider.config.robot import LINKS, HipAxes, LegJoint, Mechanism, VirtualKnee
from slider.robot.knee_map import sides
from slider.robot.names import LEG_GAIT_JOINTS, NUM_GAIT_JOINTS

LEG_JOINTS, NUM_JOINTS = LEG_GAIT_JOINTS, NUM_GAIT_JOINTS
_PITCH, _KNEE, _ANKLE = 2, 3, 4
STANCE, SWING = "stance", "swing"


@dataclass(frozen=True)
class Edge:
    """Joint from body ``parent`` to ``child`` of the rooted tree.

    ``axis``: unit vector about which the joint turns the child, opposite to the joint's own between
    stance foot and base; ``at_parent``, ``at_child``: position of the joint in the two body frames
    [m]. ``slides``: the joint is prismatic, along the axis.
    """

    parent: str
    child: str
    joint: int
    axis: np.ndarray
    at_parent: np.ndarray
    at_child: np.ndarray
    slides: bool = False

    @property
    def unit(self) -> ca.DM:
        """The axis (3,), sparse."""
        return ca.sparsify(ca.DM(self.axis))

    def rotation(self, q: ca.SX) -> ca.SX:
        """Rotation matrix (3, 3) from the child to the parent, of a revolute joint."""
        angle, along = q[self.joint], np.flatnonzero(self.axis)
        if len(along) == 1:
            return rotation(int(along[0]), float(self.axis[along[0]]) * angle)
        cross = ca.skew(ca.DM(self.axis))
        return ca.DM.eye(3) + ca.sin(angle) * cross + (1 - ca.cos(angle)) * (cross @ cross)

    def place(self, q: ca.SX) -> ca.SX:
        """Position of the joint, slide included, in the parent's frame (3,) [m]."""
        if not self.slides:
            return ca.SX(ca.DM(self.at_parent))
        return ca.DM(self.at_parent) + self.unit * q[self.joint]


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


_LEFTWARD = np.array([0.0, 1.0, 0.0])
_LINKS = LINKS | {"knee": "shank"}


def knee_leg(axes: HipAxes, knee: VirtualKnee, lateral: float) -> list[LegJoint]:
    """Left (1) or right (−1) leg with the virtual knee, which bends about −y."""
    hip = [LegJoint(*joint, slides=False) for joint in axes.chain(lateral)]
    thigh, shank = (np.array([0.0, 0.0, -each]) for each in (knee.thigh_length, knee.shank_length))
    below = LegJoint("knee", thigh, -_LEFTWARD, False), LegJoint("ankle", shank, _LEFTWARD, False)
    return [*hip, *below]


def edges_of(left: list[LegJoint], right: list[LegJoint]) -> list[Edge]:
    """Edges from the stance (left) foot up to the base and down to the swing foot."""
    edges, zero = list[Edge](), np.zeros(3)
    for side, chain in ((STANCE, left), (SWING, right)):
        parent = "base"
        for k, (name, place, axis, slides) in enumerate(chain):
            child = f"{side}_{_LINKS[name]}"
            if side == STANCE:
                ends = (0.0 - place, zero) if slides else (zero, place)  # a slide does not rotate
                edges.insert(0, Edge(child, parent, k, 0.0 - axis, *ends, slides))
            else:
                edges.append(Edge(parent, child, LEG_JOINTS + k, axis, place, zero, slides))
            parent = child
    return edges


def next_pose(pose: BodyPose, edge: Edge, q: ca.SX, v: ca.SX) -> BodyPose:
    """Pose of an edge's child from its parent's."""
    if edge.slides:
        place, rate = edge.place(q), edge.unit * v[edge.joint]
        moved = pose.linear + pose.rotation @ (ca.cross(pose.angular, place) + rate)
        return BodyPose(pose.rotation, pose.origin + pose.rotation @ place, pose.angular, moved)
    turn = edge.rotation(q)
    rot = pose.rotation @ turn
    angular = turn.T @ pose.angular + edge.unit * v[edge.joint]
    at_parent, at_child = ca.DM(edge.at_parent), ca.DM(edge.at_child)
    origin = pose.origin + pose.rotation @ at_parent - rot @ at_child
    linear = pose.linear + pose.rotation @ ca.cross(pose.angular, at_parent)
    return BodyPose(rot, origin, angular, linear - rot @ ca.cross(angular, at_child))


def _each_leg(method: Callable[..., ca.SX]) -> Callable[..., ca.SX]:
    """Apply a method on values (5,) of one leg to values (10,) of both."""

    @wraps(method)
    def on_legs(self: "LegMap", *values: ca.SX) -> ca.SX:
        legs = zip(*(ca.vertsplit(each, LEG_JOINTS) for each in values), strict=True)
        return ca.vertcat(*(method(self, *leg) for leg in legs))

    return on_legs


@dataclass(frozen=True)
class LegMap:
    """Hip pitch, leg length and ankle of the prismatic leg as functions of the knee flexion θ.

    Without a virtual knee it is the identity: gaits are in the leg's own coordinates. With one, the
    hip's last axis is pitch.

    Attributes:
        shifts: θ → shift of the hip pitch, leg length, shift of the ankle (3,) [rad, m, rad].
        slopes, curvatures: first and second derivatives of ``shifts``.
        nominal: leg length at slide = 0 [m].
    """

    shifts: ca.Function
    slopes: ca.Function
    curvatures: ca.Function
    nominal: float

    @classmethod
    def of(cls, robot: Mechanism) -> "LegMap":
        """The map of a robot's virtual knee; the identity if it has none."""
        theta, nominal = ca.SX.sym("theta"), 0.0
        values = ca.vertcat(0, theta, 0)
        if robot.virtual_knee is not None:
            l1, l2 = robot.virtual_knee.thigh_length, robot.virtual_knee.shank_length
            hip, _, length = sides(theta, l1, l2, ca)
            values, nominal = ca.vertcat(-hip, length, hip - theta), robot.geometry.leg_length
        slopes = ca.jacobian(values, theta)
        return cls(
            ca.Function("shifts", [theta], [values]),
            ca.Function("slopes", [theta], [slopes]),
            ca.Function("curvatures", [theta], [ca.jacobian(slopes, theta)]),
            nominal,
        )

    @_each_leg
    def positions(self, q: ca.SX) -> ca.SX:
        """Joint positions of the prismatic legs from those of the knee legs (5 per leg)."""
        hip, length, ankle = ca.vertsplit(self.shifts(q[_KNEE]))
        return ca.vertcat(q[:_PITCH], q[_PITCH] + hip, length - self.nominal, q[_ANKLE] + ankle)

    @_each_leg
    def velocities(self, q: ca.SX, v: ca.SX) -> ca.SX:
        """Joint velocities of the prismatic legs."""
        hip, slide, ankle = ca.vertsplit(self.slopes(q[_KNEE]) * v[_KNEE])
        return ca.vertcat(v[:_PITCH], v[_PITCH] + hip, slide, v[_ANKLE] + ankle)

    @_each_leg
    def accelerations(self, q: ca.SX, v: ca.SX, a: ca.SX) -> ca.SX:
        """Joint accelerations of the prismatic legs."""
        hip, slide, ankle = ca.vertsplit(self.slopes(q[_KNEE]) * a[_KNEE])
        linear = ca.vertcat(a[:_PITCH], a[_PITCH] + hip, slide, a[_ANKLE] + ankle)
        return linear + ca.vertcat(ca.SX.zeros(_PITCH), self.curvatures(q[_KNEE]) * v[_KNEE] ** 2)

    @_each_leg
    def knee_torques(self, q: ca.SX, efforts: ca.SX) -> ca.SX:
        """Torques of the knee legs from prismatic efforts, by virtual work: Jᵀ τ_p."""
        knee = ca.dot(self.slopes(q[_KNEE]), efforts[_PITCH:])
        return ca.vertcat(efforts[:_KNEE], knee, efforts[_ANKLE])

    @_each_leg
    def efforts(self, q: ca.SX, torques: ca.SX) -> ca.SX:
        """Prismatic efforts from torques of the knee legs, by virtual work: J⁻ᵀ τ_k."""
        hip, slide, ankle = ca.vertsplit(self.slopes(q[_KNEE]))
        force = (torques[_KNEE] - hip * torques[_PITCH] - ankle * torques[_ANKLE]) / slide
        return ca.vertcat(torques[:_KNEE], force, torques[_ANKLE])
