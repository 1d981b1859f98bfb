"""Forward kinematics of the legs, vectorised over robots. With a knee ``slide`` is its angle."""

import math
from typing import NamedTuple

import numpy as np

from slider.config.robot import Geometry
from slider.core.arrays import Array, asarray, namespace, zeros
from slider.robot.names import ANKLE, EXTENSION, LEG_SIZE, UPPER_FOOT


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
    """Yaws (N,) [rad] of rotations (N, 3, 3), body to world: where x points to on the ground."""
    return namespace(rotation).atan2(rotation[:, 1, 0], rotation[:, 0, 0])


def turn_to_heading(vectors: Array, yaw: Array) -> Array:
    """Forward and leftward components (..., 2) of world vectors (..., ≥ 2) at yaws (...) [rad].

    With −yaw it is the way back: world components of forward and leftward ones.
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

    They are (N, 2, 2, 3): foot, end, coordinate; of rotations (N, 3, 3), base to world, and joint
    positions (N, 12).
    """
    legs = [_leg(geometry, rotation, joints, leg) for leg in range(2)]
    ends = [_ends(geometry, x.ankle, x.tube, joints, leg) for leg, x in enumerate(legs)]
    return namespace(joints).stack(ends, axis=1)


_LEAST_GROWTH = 0.04  # of a leg per angle of its knee, as a share of its length
_STRAIGHTEST = 0.995  # length of a leg as a share of thigh and shank


class FootMotion(NamedTuple):
    """Ends of both feet of N robots as they move relative to the base origin, in world axes.

    Attributes:
        positions: lowest points of heel and toe (N, 2, 2, 3) [m].
        velocities: of the foot's material at these points (N, 2, 2, 3) [m/s].
        axes: unit vectors from ankle to hip (N, 2, 3).
        turning: how fast these axes turn (N, 2) [rad/s].
    """

    positions: Array
    velocities: Array
    axes: Array
    turning: Array


def foot_motion(
    geometry: Geometry, rotation: Array, turning: Array, joints: Array, rates: Array
) -> FootMotion:
    """Velocities of the feet's ends while the base origin rests.

    ``turning`` (N, 3) is the angular velocity of the base [rad/s], world axes; joint positions and
    velocities are (N, 12), ``rotation`` as in :func:`foot_ends`.
    """
    xp, count = namespace(joints), len(joints)
    positions, velocities = zeros((2, count, 2, 2, 3), joints)
    axes, turns = zeros((count, 2, 3), joints), zeros((count, 2), joints)
    for leg in range(2):
        rate = rates[:, leg * LEG_SIZE :]
        links = _leg(geometry, rotation, joints, leg)
        tube, ankle, omega = links.tube, links.ankle, turning
        place, velocity = zeros((2, count, 3), joints)  # of the base's origin
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
        else:
            velocity = velocity + xp.linalg.cross(omega, links.knee - place)
            omega = omega + tube[:, :, 1] * rate[:, EXTENSION, None]
            velocity = velocity + xp.linalg.cross(omega, ankle - links.knee)
            length = xp.linalg.vector_norm(hip - ankle, axis=1)[:, None]
            axes[:, leg] = (hip - ankle) / length
            across = xp.linalg.cross(axes[:, leg], velocity - hip_velocity) / length
            turns[:, leg] = xp.linalg.vector_norm(across, axis=1)
        omega = omega + tube[:, :, 1] * rate[:, ANKLE, None]
        positions[:, leg] = _ends(geometry, ankle, tube, joints, leg)
        arms = positions[:, leg] - ankle[:, None]
        velocities[:, leg] = velocity[:, None] + xp.linalg.cross(omega[:, None], arms)
    return FootMotion(positions, velocities, axes, turns)


def leg_points(geometry: Geometry, rotation: Array, joints: Array) -> Array:
    """Points (N, 2, 5, 3) of both legs relative to the base origin, as :func:`foot_ends` [m].

    Hip, ankle, top of the tube, back and front end of the upper foot; of a leg with a knee: hip,
    ankle, knee, and ends of the thigh.
    """
    xp, points = namespace(joints), zeros((len(joints), 2, 5, 3), joints)
    for leg in range(2):
        links = _leg(geometry, rotation, joints, leg)
        tube, ankle = links.tube, links.ankle
        if geometry.knee is not None:
            hip, _ = links.hip["hip_pitch"]
            chain = hip, ankle, links.knee, links.knee, hip
            points[:, leg] = xp.stack(chain, axis=1)
            continue
        top = ankle + tube[:, :, 2] * (geometry.leg_length + geometry.upper_foot_height)
        upper = tube @ _about_y(joints[:, leg * LEG_SIZE + UPPER_FOOT])
        points[:, leg, :3] = xp.stack([links.hip["hip_pitch"][0], ankle, top], axis=1)
        for end, x in ((3, -geometry.heel), (4, geometry.toe)):
            points[:, leg, end] = top + upper @ asarray([x, 0.0, geometry.ankle_height], joints)
    return points


class _Leg(NamedTuple):
    """Joints of a leg relative to the base origin, in world axes; rotations of links to world.

    Attributes:
        hip: place (N, 3) [m] and axis (N, 3) of each of its joints by name.
        knee, ankle: places (N, 3) [m]; the knee of a leg that slides is on its pitch axis at zero.
        tube: rotation (N, 3, 3).
    """

    hip: dict[str, tuple[Array, Array]]
    knee: Array
    ankle: Array
    tube: Array


def _leg(geometry: Geometry, rotation: Array, joints: Array, leg: int) -> _Leg:
    q, lateral, hip = joints[:, leg * LEG_SIZE :], (1.0, -1.0)[leg], {}
    below, tube = zeros((len(joints), 3), joints), rotation
    for index, (name, place, axis) in enumerate(geometry.axes.chain(lateral)):
        if place.any():
            below = below + tube @ asarray(place, joints)
        along = np.flatnonzero(axis)
        unit = tube[:, :, along[0]] if len(along) == 1 else tube @ asarray(axis, joints)
        hip[name], tube = (below, unit), tube @ _about(axis, q[:, index])
    x, y, z = geometry.knee or (0.0, 0.0, 0.0)
    from_last = ([x, y, z] - geometry.axes.below_pitch) * [1.0, lateral, 1.0]
    knee = below + tube @ asarray(from_last, joints) if from_last.any() else below
    if geometry.knee is None:
        ankle = knee - tube[:, :, 2] * (geometry.leg_length + q[:, EXTENSION])[:, None]
    else:
        tube = tube @ _about_y(q[:, EXTENSION])
        ankle = knee + tube @ asarray([-x, -lateral * y, -geometry.leg_length - z], joints)
    return _Leg(hip, knee, ankle, tube)


def leg_extension_jacobian(geometry: Geometry, extension: Array) -> Array:
    """Hip pitch, slide or knee, and ankle per length of the leg [m] at slides or knees (...).

    Along (..., 3) the leg gets longer, its direction and the foot's stay. A knee that is almost
    straight, or beyond, counts as bent by some 10°: there no angle makes the leg longer.
    """
    xp, zero = namespace(extension), 0.0 * extension
    if geometry.knee is None:
        return xp.stack([zero, zero + 1.0, zero], axis=-1)
    x, length, sense = geometry.knee[0], geometry.leg_length, -math.copysign(1.0, geometry.knee[0])
    far, deep = _hip_to_ankle(geometry, extension)
    along, down = far - x, deep - geometry.knee[2]  # the shank
    square = far**2 + deep**2
    turn = (down * deep + far * along) / square  # of the leg per angle of the knee
    grown = sense * (far * down - deep * along) / xp.sqrt(square)
    grown = sense * grown.clip(_LEAST_GROWTH * length, None)
    return xp.stack([-turn, zero + 1.0, turn - 1.0], axis=-1) / grown[..., None]


def extend_leg(geometry: Geometry, extension: Array, longer: Array) -> Array:
    """Change of hip pitch, slide or knee, and ankle (..., 3) that makes a leg ``longer`` [m].

    As :func:`leg_extension_jacobian`, exactly, at slides or knees ``extension`` (...). A leg with a
    knee gets as long as it can.
    """
    xp, zero = namespace(extension), 0.0 * extension
    if geometry.knee is None:
        return xp.stack([zero, longer, zero], axis=-1)
    x, _, z = geometry.knee
    thigh, shank = math.hypot(x, z), math.hypot(x, geometry.leg_length + z)
    before = _hip_to_ankle(geometry, extension)
    length = (before[0] ** 2 + before[1] ** 2) ** 0.5 + longer
    length = length.clip(abs(thigh - shank), _STRAIGHTEST * (thigh + shank))
    cosine = (length**2 - thigh**2 - shank**2) / (2 * thigh * shank)
    knee = math.copysign(1.0, x) * xp.acos(cosine.clip(-1.0, 1.0)) - geometry.bend
    after = _hip_to_ankle(geometry, knee)
    turn = xp.atan2(-after[0], -after[1]) - xp.atan2(-before[0], -before[1])
    bent = knee - extension
    return xp.stack([-turn, bent, turn - bent], axis=-1)


def _hip_to_ankle(geometry: Geometry, knee: Array) -> tuple[Array, Array]:
    """Ankle from the pitch axis, forward and up with roll and yaw below it at zero [m]."""
    xp, (x, _, z) = namespace(knee), geometry.knee or (0.0, 0.0, 0.0)
    sine, cosine, shank = xp.sin(knee), xp.cos(knee), geometry.leg_length + z
    return x - x * cosine - shank * sine, z + x * sine - shank * cosine


def _ends(geometry: Geometry, ankle: Array, tube: Array, joints: Array, leg: int) -> Array:
    """Lowest points of heel and toe (N, 2, 3), of ankle and rotation of the tube."""
    foot = tube @ _about_y(joints[:, leg * LEG_SIZE + ANKLE])
    height, ends = geometry.foot_radius - geometry.ankle_height, zeros((len(joints), 2, 3), joints)
    for end, x in enumerate((-geometry.heel, geometry.toe)):
        centre = foot @ asarray([x, 0.0, height], joints)
        ends[:, end] = ankle + centre - asarray([0.0, 0.0, geometry.foot_radius], joints)
    return ends


def standing_height(geometry: Geometry, rotation: Array, joints: Array) -> Array:
    """Height of the base [m] (N,) at which the lowest foot point touches flat ground."""
    heights = foot_ends(geometry, rotation, joints)[..., 2]
    return -namespace(heights).amin(heights, axis=(1, 2))


def about_z(angle: Array) -> Array:
    """Rotations (N, 3, 3) about the vertical by angles (N,) [rad]."""
    return _rotation(angle, 0, 1)


def about_x(angle: Array) -> Array:
    """As :func:`about_z`, about x."""
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
