"""Metrics of one recorded rollout, as columns (N,) over robots: tracking and gait quality.

All except ``survived`` and ``tracked`` are NaN where a robot fell.
"""

import numpy as np

from slider.env.instruments import CONTACT_FORCE, Contacts, in_contact, landings
from slider.env.rollout import Recording
from slider.robot.kinematics import turn_to_heading

TOGETHER = 0.02  # feet that touch down within less than this do so together [s]
TRACKING = ("survived", "squared_error", "squared_error_steady", "mean_velocity", "tracked")
ERRORS = ("estimate_vx", "estimate_vy", "estimate_height", "estimate_tilt")
QUALITY = (
    *("flight", "double_support", "touchdown_rate", "contact_rate", "alternation", "clearance"),
    *("slip", "penetration", "penetration_max", "heading", "asymmetry", "velocity_variance"),
    *("cost_of_transport", "peak_effort", "peak_speed", "leg_distance", "legs_touch", "legs_cross"),
)
Columns = dict[str, np.ndarray]
"""Values (N,) by the name of a metric."""


def tracking(recording: Recording, warm_up: float, tolerance: float, relative: float) -> Columns:
    """Velocity tracking, ``TRACKING``.

    ``survived``: no termination; ``squared_error``: mean over all control steps of (forward
    velocity − command)² [m²/s²]; ``squared_error_steady``: the same from ``warm_up`` on;
    ``mean_velocity``: forward, from ``warm_up`` on [m/s]; ``tracked``: survived and
    |mean v − command| ≤ max(tolerance, relative·|command|). The command is the forward one; if
    it changes, ``tracked`` uses its mean from ``warm_up`` on.
    """
    first = round(warm_up / recording.period)
    survived = recording.survived
    forward = recording.velocity[:, :, 0]
    command = recording.command[:, :, 0]
    error = (forward - command) ** 2
    mean = forward[first:].mean(axis=0)
    target = command[first] + (command[first:] - command[first]).mean(axis=0)  # exact if constant
    allowed = np.maximum(tolerance, relative * np.abs(target))
    return {
        "survived": survived,
        "squared_error": _where(survived, error.mean(axis=0)),
        "squared_error_steady": _where(survived, error[first:].mean(axis=0)),
        "mean_velocity": _where(survived, mean),
        "tracked": survived & (np.abs(mean - target) <= allowed),
    }


def estimate_error(recording: Recording, warm_up: float) -> Columns:
    """Root mean square errors of the state that the controller receives, from ``warm_up`` on.

    ``ERRORS``: velocity in the heading frame [m/s], height of the base [m], angle between the
    directions of gravity [rad].
    """
    errors = recording.estimate_error[round(warm_up / recording.period) :]
    rms = np.sqrt((errors.astype(float) ** 2).mean(axis=0))
    return dict(zip(ERRORS, _where(recording.survived[:, None], rms).T, strict=True))


def gait_quality(recording: Recording, warm_up: float) -> Columns:
    """Gait quality from ``warm_up`` on, ``QUALITY``.

    Contacts are evaluated at every simulation step, motion at every control step.

    Returns:
        flight: share of time with no foot on the ground, bounces removed; see
            :func:`slider.env.instruments.in_contact`.
        double_support: share of time with both feet on the ground, likewise.
        touchdown_rate: touchdowns per second, both feet, likewise.
        contact_rate: onsets of contact per second, both feet, bounces included.
        alternation: share of touchdowns that follow one of the other foot; two feet that touch down
            together follow none.
        clearance: mean over feet of the 90th percentile over time of the sole's height [m], which
            counts as 0 while the foot is loaded.
        slip: mean horizontal speed of heels and toes while loaded, at the points that touch [m/s].
        penetration: mean depth of a foot's lower end in the ground while the foot carries more than
            ``CONTACT_FORCE`` [m].
        penetration_max: the greatest such depth [m].
        heading: largest |yaw − commanded yaw| [rad] of the entire rollout; the commanded yaw is the
            initial yaw plus the integral of the commanded yaw rate.
        asymmetry: |mean time from a left to the next right touchdown − from right to left| over
            their sum, where a foot that touches down several times in a row counts with the first;
            1 where the feet do not alternate.
        velocity_variance: variance of the forward velocity [m²/s²].
        cost_of_transport: mean absolute power of the motors / (m g · |mean forward velocity|) [-].
        peak_effort, peak_speed: largest share of a motor's limit [-].
        leg_distance: least distance between the two legs in the entire rollout [m]; negative where
            they pressed on each other.
        legs_touch: share of the entire rollout in which the legs touch.
        legs_cross: share of the entire rollout in which the middle of the left foot is to the right
            of that of the right foot, in the heading frame.
    """
    first, tick = round(warm_up / recording.period), round(warm_up / recording.timestep)
    forces, per_second = recording.contacts.forces, 1.0 / recording.timestep
    contact = in_contact(forces, recording.timestep)
    touchdown, contact = landings(contact)[tick:], contact[tick:]
    bounces = landings(forces > CONTACT_FORCE)[tick:]
    settled = Contacts(*(series[tick:] for series in recording.contacts))
    loaded = recording.foot_forces[first:] > CONTACT_FORCE
    carrying = settled.forces > CONTACT_FORCE
    sunk = np.where(carrying, settled.depths, 0.0).clip(min=0.0)
    heights = np.where(loaded, 0.0, recording.foot_positions[first:][..., 2])
    distance = recording.contacts.leg_distance
    left, right = np.moveaxis(recording.foot_positions, 2, 0)
    apart = turn_to_heading(left - right, recording.yaw)[..., 1]
    values = {
        "flight": (~contact.any(axis=2)).mean(axis=0),
        "double_support": contact.all(axis=2).mean(axis=0),
        "touchdown_rate": touchdown.sum(axis=2).mean(axis=0) * per_second,
        "contact_rate": bounces.sum(axis=2).mean(axis=0) * per_second,
        "alternation": _alternation(touchdown, TOGETHER / recording.timestep),
        "clearance": np.percentile(heights, 90, axis=0).mean(axis=1),
        "slip": _slip(settled),
        "penetration": (sunk.sum(axis=(0, 2)) / np.maximum(carrying.sum(axis=(0, 2)), 1)),
        "penetration_max": sunk.max(axis=(0, 2)),
        "heading": np.abs(heading_error(recording)).max(axis=0),
        "asymmetry": _asymmetry(touchdown),
        "velocity_variance": recording.velocity[first:, :, 0].var(axis=0),
        "cost_of_transport": _cost_of_transport(recording, first),
        "peak_effort": recording.effort_share[first:].max(axis=0),
        "peak_speed": recording.speed_share[first:].max(axis=0),
        "leg_distance": distance.min(axis=0),
        "legs_touch": (distance <= 0).mean(axis=0),
        "legs_cross": (apart < 0).mean(axis=0),
    }
    return {name: _where(recording.survived, values[name]) for name in QUALITY}


def heading_error(recording: Recording) -> np.ndarray:
    """Yaw minus commanded yaw (S, N) [rad], both relative to the first step."""
    turned = np.unwrap(recording.yaw, axis=0) - recording.yaw[0]
    commanded = np.cumsum(recording.command[:, :, 2], axis=0) * recording.period
    return turned - (commanded - commanded[0])


def _where(survived: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.where(survived, values, np.nan)


def _alternation(touchdown: np.ndarray, together: float) -> np.ndarray:
    """Share (N,) of touchdowns (T, N, 2) that follow one of the other foot.

    Touchdowns fewer than ``together`` simulation steps from one of the other foot follow none.
    """
    share = np.zeros(touchdown.shape[1])
    for robot in range(touchdown.shape[1]):
        times, feet = np.nonzero(touchdown[:, robot])
        if len(feet) > 1:
            other = feet[:, None] != feet
            close = np.abs(times[:, None] - times) < together - 1e-6
            share[robot] = np.mean((feet[1:] != feet[:-1]) & ~(other & close).any(axis=1)[1:])
    return share


def _asymmetry(touchdown: np.ndarray) -> np.ndarray:
    """Asymmetry (N,) of step times; of touchdowns (T, N, 2) of a foot in a row the first counts."""
    result = np.ones(touchdown.shape[1])
    for robot in range(touchdown.shape[1]):
        steps, feet = np.nonzero(touchdown[:, robot])
        first = np.diff(feet, prepend=-1) != 0
        times, feet = np.diff(steps[first]), feet[first]
        left, right = (times[feet[1:] == foot] for foot in range(2))
        if len(left) and len(right):
            one, other = left.mean(), right.mean()
            result[robot] = abs(one - other) / (one + other)
    return result


def _cost_of_transport(recording: Recording, first: int) -> np.ndarray:
    """Cost of transport (N,); infinite at zero mean velocity."""
    speed = np.abs(recording.velocity[first:, :, 0].mean(axis=0))
    power = recording.power[first:].mean(axis=0) / recording.weight
    return np.divide(power, speed, out=np.full_like(power, np.inf), where=speed > 0)


def _slip(contacts: Contacts) -> np.ndarray:
    """Mean speed (N,) of ends loaded for two steps in a row: speed at touchdown is not slip."""
    loaded = contacts.loaded[1:] & contacts.loaded[:-1]
    count = loaded.sum(axis=(0, 2, 3))
    total = np.where(loaded, contacts.speeds[1:], 0.0).sum(axis=(0, 2, 3), dtype=float)
    return total / np.maximum(count, 1)
