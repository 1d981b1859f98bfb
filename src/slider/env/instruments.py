"""Contacts, distance of the legs and loads of the motors at every simulation step, for metrics.

Touchdowns and peaks of the motors' loads occur between control steps, too.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from slider.env.height_field import Ground
from slider.robot.transmission import Transmission

CONTACT_FORCE = 5.0  # a foot that carries more than this is in contact [N]
# Gaps and contacts shorter than these are bounces [s].
LIFT_TIME = 0.03  # a foot that loses contact for less has not been lifted
TOUCH_TIME = 0.02  # a contact that lasts less is a graze


class Contacts(NamedTuple):
    """Feet and legs of N robots at T simulation steps; feet left, right; ends heel, toe.

    Attributes:
        forces: (T, N, 2) vertical ground reaction of each foot [N].
        loaded: (T, N, 2, 2) the foot carries more than ``CONTACT_FORCE`` and this end touches: it
            is the lower one (uneven ground may carry a foot between its ends), or it has sunk in.
        speeds: (T, N, 2, 2) horizontal speed of the lowest point of each end [m/s].
        depths: (T, N, 2) penetration of each foot's lower end [m]; negative: above the ground.
        leg_distance: (T, N) between the closest parts of the two legs [m]; negative: they press
            on each other.
    """

    forces: np.ndarray
    loaded: np.ndarray
    speeds: np.ndarray
    depths: np.ndarray
    leg_distance: np.ndarray


def observe(
    forces: np.ndarray,
    ends: np.ndarray,
    velocities: np.ndarray,
    distances: np.ndarray,
    ground: Ground,
) -> Contacts:
    """Contacts of N robots from their sensors over T simulation steps.

    Args:
        forces: of the feet (N, T, 2) [N].
        ends, velocities: lowest points of heel and toe [m] in the ground's world, and velocities of
            the foot there [m/s], (N, T, 2, 2, 3).
        distances: between pairs of parts of the two legs (N, T, pairs) [m].
        ground: below the robots.
    """
    # MuJoCo's contacts begin at a height of 0, and a foot that carries weight sinks in.
    height = ends[..., 2] - ground.height(ends[..., :2])
    lower = np.minimum(height[..., 0], height[..., 1])[..., None]
    touching = (height <= 0.0) | (height == lower)
    forward, left = velocities[..., 0], velocities[..., 1]
    series = (
        forces.astype(np.float32),
        (forces > CONTACT_FORCE)[..., None] & touching,
        np.sqrt(forward * forward + left * left).astype(np.float32),
        -lower[..., 0].astype(np.float32),
        distances.min(axis=-1).astype(np.float32),
    )
    return Contacts(*(np.swapaxes(values, 0, 1) for values in series))


def join(parts: Sequence[Contacts]) -> Contacts:
    """Concatenate contacts in time."""
    return Contacts(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def in_contact(forces: np.ndarray, timestep: float) -> np.ndarray:
    """Feet on the ground (T, N, 2), from forces (T, N, 2) [N] every ``timestep`` [s].

    Bounces are removed: first gaps shorter than ``LIFT_TIME``, then contacts shorter than
    ``TOUCH_TIME``.
    """
    contact = _without_gaps(forces > CONTACT_FORCE, LIFT_TIME / timestep)
    return ~_without_gaps(~contact, TOUCH_TIME / timestep)


def landings(contact: np.ndarray) -> np.ndarray:
    """Touchdowns (T, N, 2): feet in ``contact`` (T, N, 2) that were not one step before.

    A foot in contact at the first step has no touchdown there.
    """
    touchdown = contact.copy()
    touchdown[1:] &= ~contact[:-1]
    touchdown[:1] = False
    return touchdown


def _without_gaps(flags: np.ndarray, length: float) -> np.ndarray:
    """Flags (T, ...) with gaps of fewer than ``length`` unset ones between set ones filled."""
    count = len(flags)
    index = np.arange(count, dtype=np.int32).reshape((-1,) + (1,) * (flags.ndim - 1))
    last = np.maximum.accumulate(np.where(flags, index, -count), axis=0)
    following = np.minimum.accumulate(np.where(flags, index, 2 * count)[::-1], axis=0)[::-1]
    return flags | (following - last - 1 < length - 1e-6)


class DriveLoads(NamedTuple):
    """Loads of N robots over some simulation steps.

    Attributes:
        power: (N,) sum of the motors' absolute mechanical powers, mean over the steps [W].
        effort_share: (N,) largest torque of a motor as a share of its limit [-].
        speed_share: (N,) largest speed of a motor as a share of its no-load speed [-]; beyond 1,
            where the leg drives the motor, it can only brake.
    """

    power: np.ndarray
    effort_share: np.ndarray
    speed_share: np.ndarray


def acting_torques(
    motors: Transmission, damping: np.ndarray, demanded: np.ndarray, speeds: np.ndarray
) -> np.ndarray:
    """Motor torques (N, T, 10) [N m] that act during T simulation steps.

    MuJoCo's sensors read the torque at the start of a step. Its implicit integrator subtracts the
    change of speed times a slope: the position loop's damping, the slope of the torque-speed line
    at the voltage limit, or zero at the torque limit.

    Args:
        motors: of the robots; torques are (N, 1, 10) where robots differ.
        damping: of the position loops [N m s/rad], like the torques; zero without such loops.
        demanded: torques at the start of each step (N, T, 10) [N m].
        speeds: of the motors at the start and after each step (N, T + 1, 10) [rad/s].
    """
    before, change = speeds[:, :-1], np.diff(speeds, axis=1)
    by_voltage = np.abs(demanded / motors.stall + before / motors.speed) > 1.0 - 1e-9
    slope = np.where(by_voltage, motors.stall / motors.speed, damping)
    slope[np.abs(demanded) > (1.0 - 1e-9) * motors.torque] = 0.0
    return demanded - slope * change


def loads(motors: Transmission, torques: np.ndarray, speeds: np.ndarray) -> DriveLoads:
    """Loads from acting motor torques (N, T, 10) [N m] and speeds after the steps [rad/s].

    The power is that at the speed after a step, with which MuJoCo integrates positions.
    """
    torque, speed = np.abs(torques), np.abs(speeds)
    return DriveLoads(
        power=(torque * speed).sum(axis=2).mean(axis=1),
        effort_share=(torque / motors.torque).max(axis=(1, 2)),
        speed_share=(speed / motors.speed).max(axis=(1, 2)),
    )


def over(loads: Sequence[DriveLoads]) -> DriveLoads:
    """Mean power and peaks over intervals of equal length."""
    power, effort, speed = (np.stack(column) for column in zip(*loads, strict=True))
    return DriveLoads(power.mean(axis=0), effort.max(axis=0), speed.max(axis=0))
