"""Forward kinematics of the legs, vectorised over robots. A knee's angle is named ``slide``."""

import math
from typing import NamedTuple

import numpy as np

from slider.config.robot import Geometry, axis_of
from slider.core.arrays import Array, asarray, namespace, zeros
from slider.robot.names import ANKLE, EXTENSION, LAST, LEG_GAIT_JOINTS, LEG_SIZE


def rotation_from_quaternion(quaternion: Array) -> Array:
    """Rotation matrices (N, 3, 3), body to world, of unit quaternions (N, 4) as w, x, y, z."""
    w, x, y, z = quaternion.T
    rotation = zeros((len(quaternion), 3, 3), quaternion)
    rotation[:, 0, 0] = 1 - 2 * (y * y + z * z)
    rotation[:, 0, 1] = 2 * (x * y - w * z)
    rotation[:, 0, 2] = 2 * (x * z + w * y)
    rotation[:, 1, 0] = 2 * (x * y + w * z)
    rotation[:, 1, 1] = 1 - 2 * (x * x + z * z)
    rotation[:, 1, 2] = 2 * (y * z - w * x)
    rotation[:, 2, 0] = 2 * (x * z - w * y)
    rotation[:, 2, 1] = 2 * (y * z + w * x)
    rotation[:, 2, 2] = 1 - 2 * (x * x + y * y)
    return rotation


def yaw_of(rotation: Array) -> Array:
    """Yaws (N,) [rad] of rotations (N, 3, 3), body to world: horizontal direction of the x axis."""
    return namespace(rotation).atan2(rotation[:, 1, 0], rotation[:, 0, 0])


def turn_to_heading(vectors: Array, yaw: Array) -> Array:
    """Forward and leftward components (..., 2) of world vectors (..., ≥ 2) at yaws (...) [rad].

    With −yaw it is the inverse: world components of forward and leftward components.
    """
    xp = namespace(vectors)
    x, y, cosine, sine = vectors[..., 0], vectors[..., 1], xp.cos(yaw), xp.sin(yaw)
    return xp.stack([cosine * x + sine * y, -sine * x + cosine * y], axis=-1)


def quaternion_from_tilt(roll: Array, pitch: Array) -> Array:
    """Unit quaternions (N, 4), pitch about y after roll about x, both (N,) in rad."""
    xp = namespace(roll)
    cr, sr = xp.cos(roll / 2), xp.sin(roll / 2)
    cp, sp = xp.cos(pitch / 2), xp.sin(pitch / 2)
    return xp.stack([cp * cr, cp * sr, sp * cr, -sp * sr], axis=1)


def foot_ends(geometry: Geometry, rotation: Array, joints: Array) -> Array:
    """Lowest points of heel and toe of both feet relative to the base origin, in world axes [m].

    Shape (N, 2, 2, 3): foot, end, coordinate; for rotations (N, 3, 3), base to world, and joint
    positions (N, 12).
    """
    ends = [_ends(geometry, _leg(geometry, rotation, joints, leg)) for leg in range(2)]
    return namespace(joints).stack(ends, axis=1)


_LEAST_GROWTH = 0.04  # minimum length change per knee angle, as a share of leg length [1/rad]
_STRAIGHTEST = 0.995  # maximum length of a leg as a share of thigh + shank
_ITERATIONS = 6  # iterations of Newton's method


class FootMotion(NamedTuple):
    """Motion of the ends of both feet of N robots relative to the base origin, in world axes.

    Attributes:
        positions: lowest points of heel and toe (N, 2, 2, 3) [m].
        velocities: velocities of the foot's material points there (N, 2, 2, 3) [m/s].
        axes: unit vectors from ankle to hip (N, 2, 3).
        turning: angular speeds of these axes (N, 2) [rad/s].
        excess: leg lengths minus the nominal leg length (N, 2) [m].
        growing: rate of ``excess`` (N, 2) [m/s].
    """

    positions: Array
    velocities: Array
    axes: Array
    turning: Array
    excess: Array
    growing: Array


def foot_motion(
    geometry: Geometry, rotation: Array, turning: Array, joints: Array, rates: Array
) -> FootMotion:
    """Motion of the feet's ends relative to the base origin.

    ``turning`` (N, 3) is the angular velocity of the base [rad/s], world axes; joint positions and
    velocities are (N, 12), ``rotation`` as in :func:`foot_ends`.
    """
    xp, count = namespace(joints), len(joints)
    positions, velocities = zeros((2, count, 2, 2, 3), joints)
    axes, (turns, excess, growing) = zeros((count, 2, 3), joints), zeros((3, count, 2), joints)
    for leg in range(2):
        rate = rates[:, leg * LEG_SIZE :]
        links = _leg(geometry, rotation, joints, leg)
        tube, ankle, omega = links.tube, links.ankle, turning
        place, velocity = zeros((2, count, 3), joints)  # of the base origin
        hip = hip_velocity = place
        for index, name in enumerate(geometry.axes.order):
            following, axis = links.hip[name]
            velocity = velocity + xp.linalg.cross(omega, following - place)
            omega, place = omega + axis * rate[:, index, None], following
            if name == "hip_pitch":
                hip, hip_velocity = place, velocity
        if geometry.knee is None:
            axes[:, leg] = tube[:, :, 2]
            turns[:, leg] = xp.linalg.vector_norm(xp.linalg.cross(omega, tube[:, :, 2]), axis=1)
            velocity = velocity + xp.linalg.cross(omega, ankle - place)
            velocity = velocity - tube[:, :, 2] * rate[:, EXTENSION, None]
            slide = joints[:, leg * LEG_SIZE + EXTENSION]
            excess[:, leg], growing[:, leg] = slide, rate[:, EXTENSION]
        else:
            velocity = velocity + xp.linalg.cross(omega, links.knee - place)
            omega = omega + links.axes[0] * rate[:, EXTENSION, None]
            velocity = velocity + xp.linalg.cross(omega, ankle - links.knee)
            length = xp.linalg.vector_norm(hip - ankle, axis=1)[:, None]
            axes[:, leg] = (hip - ankle) / length
            apart = hip_velocity - velocity
            across = xp.linalg.cross(axes[:, leg], apart) / length
            turns[:, leg] = xp.linalg.vector_norm(across, axis=1)
            excess[:, leg] = length[:, 0] - geometry.leg_length
            growing[:, leg] = (axes[:, leg] * apart).sum(-1)
        omega = omega + links.axes[1] * rate[:, ANKLE, None]
        if geometry.sole is not None:
            velocity = velocity + xp.linalg.cross(omega, links.above_ground - ankle)
            omega = omega + links.foot[:, :, 0] * rate[:, LAST, None]
        positions[:, leg] = _ends(geometry, links)
        arms = positions[:, leg] - links.above_ground[:, None]
        velocities[:, leg] = velocity[:, None] + xp.linalg.cross(omega[:, None], arms)
    return FootMotion(positions, velocities, axes, turns, excess, growing)


def leg_points(geometry: Geometry, rotation: Array, joints: Array) -> Array:
    """Points (N, 2, 5, 3) of both legs relative to the base origin, in world axes [m].

    Hip, ankle, top of the tube, rear and front end of the upper foot; for a leg with a knee: hip,
    ankle, knee, and ends of the thigh.
    """
    xp, points = namespace(joints), zeros((len(joints), 2, 5, 3), joints)
    for leg in range(2):
        links = _leg(geometry, rotation, joints, leg)
        tube, ankle = links.tube, links.ankle
        if geometry.knee is not None or geometry.sole is not None:
            hip, _ = links.hip["hip_pitch"]
            chain = hip, ankle, links.knee, links.knee, hip
            points[:, leg] = xp.stack(chain, axis=1)
            continue
        top = ankle + tube[:, :, 2] * (geometry.leg_length + geometry.upper_foot_height)
        upper = tube @ _about_y(joints[:, leg * LEG_SIZE + LAST])
        points[:, leg, :3] = xp.stack([links.hip["hip_pitch"][0], ankle, top], axis=1)
        for end, x in ((3, -geometry.heel), (4, geometry.toe)):
            points[:, leg, end] = top + upper @ asarray([x, 0.0, geometry.ankle_height], joints)
    return points


class _Leg(NamedTuple):
    """Joints of a leg relative to the base origin, in world axes; rotations of links to world.

    Attributes:
        hip: position (N, 3) [m] and axis (N, 3) of each hip joint by name.
        knee, ankle: positions (N, 3) [m]; for a sliding leg, the knee is on the pitch axis.
        above_ground: position of the last joint above the ground (N, 3) [m]: ankle or its roll.
        axes: of the knee (meaningless for a sliding leg) and of the ankle (N, 3).
        tube, foot: rotations (N, 3, 3).
    """

    hip: dict[str, tuple[Array, Array]]
    knee: Array
    ankle: Array
    above_ground: Array
    axes: tuple[Array, Array]
    tube: Array
    foot: Array


def _leg(geometry: Geometry, rotation: Array, joints: Array, leg: int) -> _Leg:
    q, lateral, hip = joints[:, leg * LEG_SIZE :], (1.0, -1.0)[leg], {}
    below, tube = zeros((len(joints), 3), joints), rotation
    for index, (name, place, axis) in enumerate(geometry.axes.chain(lateral)):
        if place.any():
            below = below + tube @ asarray(place, joints)
        hip[name], tube = (below, tube @ asarray(axis, tube)), tube @ _about(axis, q[:, index])
    x, y, z = geometry.knee or (0.0, 0.0, 0.0)
    from_last = ([x, y, z] - geometry.axes.below_pitch) * [1.0, lateral, 1.0]
    knee = below + tube @ asarray(from_last, joints) if from_last.any() else below
    bends = axis_of("slide", geometry.knee_direction, lateral)
    turns = axis_of("ankle", geometry.ankle_direction, lateral)
    unit = tube @ asarray(bends, tube)
    if geometry.knee is None:
        ankle = knee - tube[:, :, 2] * (geometry.leg_length + q[:, EXTENSION])[:, None]
    else:
        tube = tube @ _about(bends, q[:, EXTENSION])
        ankle = knee + tube @ asarray([-x, -lateral * y, -geometry.leg_length - z], joints)
    axes, foot = (unit, tube @ asarray(turns, tube)), tube @ _about(turns, q[:, ANKLE])
    above_ground = ankle
    if geometry.sole is not None:
        above_ground = ankle + foot @ asarray(geometry.ankle_roll, ankle)
        foot = foot @ about_x(q[:, LAST])
    return _Leg(hip, knee, ankle, above_ground, axes, tube, foot)


def leg_extension_jacobian(geometry: Geometry, joints: Array, leg: int) -> Array:
    """Derivatives of a leg's driven joints (N, 5) by leg length [m] at joint positions (N, 12).

    The directions of the leg and of the foot's line are kept. A knee that is almost straight, or
    overextended, is treated as bent by about 10°, since a straight knee cannot lengthen the leg.
    """
    if geometry.knee is None:
        return _slid(zeros(len(joints), joints) + 1.0)
    bent = _Bent.of(geometry, joints, leg)
    return bent.towards(geometry, bent.away, 0.0 * bent.away)


def extend_leg(geometry: Geometry, joints: Array, leg: int, longer: Array) -> Array:
    """Change of a leg's driven joints (N, 5) that lengthens it by ``longer`` (N,) [m].

    The nonlinear counterpart of :func:`leg_extension_jacobian` at joint positions (N, 12). The
    length of a leg with a knee is limited by thigh and shank.
    """
    if geometry.knee is None:
        return _slid(longer)
    x, _, z = geometry.knee
    thigh, shank = math.hypot(x, z), math.hypot(x, geometry.leg_length + z)
    start = _Bent.of(geometry, joints, leg)
    length = (start.length[:, 0] + longer).clip(abs(thigh - shank), _STRAIGHTEST * (thigh + shank))
    goal = start.ankle + (length[:, None] - start.length) * start.away
    driven = slice(leg * LEG_SIZE, leg * LEG_SIZE + LEG_GAIT_JOINTS)
    moved = 1.0 * joints
    for _ in range(_ITERATIONS):
        now = _Bent.of(geometry, moved, leg)
        turn = namespace(joints).linalg.cross(now.line, start.line)
        moved[:, driven] += now.towards(geometry, goal - now.ankle, turn)
    return moved[:, driven] - joints[:, driven]


def _slid(longer: Array) -> Array:
    """Change of a leg's driven joints (N, 5) where only the slide moves, by lengths (N,) [m]."""
    values = zeros((len(longer), LEG_GAIT_JOINTS), longer)
    values[:, EXTENSION] = longer
    return values


class _Bent(NamedTuple):
    """A leg with a knee of N robots, in the base frame.

    Attributes:
        ankle, line: position (N, 3) [m]; unit vector along the foot's line (N, 3).
        away, length: unit vector (N, 3) and distance (N, 1) [m] from hip to ankle.
        across: two directions perpendicular to the leg, two to the foot's line, (N, 2, 3) each.
        moves, turns: Jacobians of ankle position [m/rad] and foot rotation (N, 5, 3).
    """

    ankle: Array
    line: Array
    away: Array
    length: Array
    across: tuple[Array, Array]
    moves: Array
    turns: Array

    @classmethod
    def of(cls, geometry: Geometry, joints: Array, leg: int) -> "_Bent":
        """The leg at joint positions (N, 12)."""
        xp, cross = namespace(joints), namespace(joints).linalg.cross
        level = asarray(np.tile(np.eye(3), (len(joints), 1, 1)), joints)
        links = _leg(geometry, level, joints, leg)
        ankle, (bends, rolls) = links.ankle, links.axes
        parts = [*links.hip.values(), (links.knee, bends), (ankle, rolls)]
        places, turns = (xp.stack(values, axis=1) for values in zip(*parts, strict=True))
        away = ankle - links.hip["hip_pitch"][0]
        length = xp.linalg.vector_norm(away, axis=1)[:, None]
        away, forward = away / length, cross(level[:, :, 1], away)
        leg_across = xp.stack([forward, cross(away, forward)], axis=1)
        across = leg_across, xp.stack([links.foot[:, :, 1], links.foot[:, :, 2]], axis=1)
        moves = cross(turns, ankle[:, None] - places)
        return cls(ankle, links.foot[:, :, 0], away, length, across, moves, turns)

    def towards(self, geometry: Geometry, place: Array, turn: Array) -> Array:
        """Joint change (N, 5) that moves the ankle by ``place`` and turns the line by ``turn``."""
        xp, cross = namespace(place), namespace(place).linalg.cross
        ways, motions = self.across, (self.moves, self.turns)
        moves, turns = (
            (way[:, :, None] * by[:, None]).sum(-1) for way, by in zip(ways, motions, strict=True)
        )
        moved, turned = (
            (way * to[:, None]).sum(-1) for way, to in zip(ways, (place, turn), strict=True)
        )
        # The ankle joint does not move the ankle; its rotation of the line is eliminated.
        share = turns[:, 1, ANKLE] / turns[:, 0, ANKLE]
        last = turns[:, 1] - share[:, None] * turns[:, 0]
        rows = xp.stack([moves[:, 0], moves[:, 1], last], axis=1)
        goal = xp.stack([moved[:, 0], moved[:, 1], turned[:, 1] - share * turned[:, 0]], axis=1)
        one, two, three = (rows[:, k, :EXTENSION] for k in range(3))
        inverse = xp.stack([cross(two, three), cross(three, one), cross(one, two)], axis=1)
        inverse = inverse / (one * inverse[:, 0]).sum(-1)[:, None, None]
        still, carried = (
            (side[:, :, None] * inverse).sum(1) for side in (goal, -rows[:, :, EXTENSION])
        )
        along = (self.moves * self.away[:, None]).sum(-1)
        goes, grown = ((along[:, :EXTENSION] * hip).sum(-1) for hip in (still, carried))
        sense = -math.copysign(1.0, geometry.bend)
        grown = sense * (grown + along[:, EXTENSION])
        grown = sense * grown.clip(_LEAST_GROWTH * geometry.leg_length, None)
        bent = (((place * self.away).sum(-1) - goes) / grown)[:, None]
        upper = xp.concat([still + carried * bent, bent], axis=1)
        rest = turned[:, 0] - (turns[:, 0, :ANKLE] * upper).sum(-1)
        return xp.concat([upper, (rest / turns[:, 0, ANKLE])[:, None]], axis=1)


def _ends(geometry: Geometry, leg: _Leg) -> Array:
    """Lowest points of heel and toe (N, 2, 3)."""
    radius = geometry.foot_radius if geometry.sole is None else 0.0
    ends, down = zeros((len(leg.ankle), 2, 3), leg.ankle), asarray([0.0, 0.0, radius], leg.ankle)
    for end, x in enumerate((-geometry.heel, geometry.toe)):
        centre = leg.foot @ asarray([x, 0.0, radius - geometry.sole_height], leg.ankle)
        ends[:, end] = leg.above_ground + centre - down
    return ends


def standing_height(geometry: Geometry, rotation: Array, joints: Array) -> Array:
    """Height of the base [m] (N,) at which the lowest foot point touches flat ground."""
    heights = foot_ends(geometry, rotation, joints)[..., 2]
    return -namespace(heights).amin(heights, axis=(1, 2))


def about_z(angle: Array) -> Array:
    """Rotations (N, 3, 3) about the vertical by angles (N,) [rad]."""
    return _rotation(angle, 0, 1)


def about_x(angle: Array) -> Array:
    """Rotations (N, 3, 3) about x by angles (N,) [rad]."""
    return _rotation(angle, 1, 2)


def _about_y(angle: Array) -> Array:
    return _rotation(angle, 2, 0)


def _about(axis: np.ndarray, angle: Array) -> Array:
    """Rotations (N, 3, 3) about a unit vector (3,) by angles (N,) [rad]."""
    along = np.flatnonzero(axis)
    if len(along) == 1 and axis[along[0]] > 0.0:
        return (about_x, _about_y, about_z)[along[0]](angle)
    cross = asarray(np.cross(np.eye(3), axis), angle)  # [axis]×
    sine, versine = namespace(angle).sin(angle), 1.0 - namespace(angle).cos(angle)
    turned = sine[:, None, None] * cross + versine[:, None, None] * (cross @ cross)
    return turned + asarray(np.eye(3), angle)


def _rotation(angle: Array, first: int, second: int) -> Array:
    """Rotation by an angle that turns axis ``first`` towards axis ``second``."""
    xp, matrix = namespace(angle), zeros((len(angle), 3, 3), angle)
    cosine, sine = xp.cos(angle), xp.sin(angle)
    matrix[:, 3 - first - second, 3 - first - second] = 1.0
    matrix[:, first, first] = matrix[:, second, second] = cosine
    matrix[:, first, second], matrix[:, second, first] = -sine, sine
    return matrix
