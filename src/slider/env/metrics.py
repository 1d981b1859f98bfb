"""Numbers about one recorded rollout: per robot tracking and quality of the gait."""

from dataclasses import dataclass

import numpy as np

from slider.env.rollout import Recording

CONTACT_FORCE = 5.0  # a foot with more than this on it is on the ground [N]


@dataclass(frozen=True)
class Tracking:
    """Velocity tracking per robot (N,); NaN where a robot fell.

    Attributes:
        survived: no termination.
        squared_error: mean over all control steps of (forward velocity − command)² [m²/s²].
        squared_error_steady: the same from ``steady_from`` on.
        mean_velocity: mean forward velocity from ``steady_from`` on [m/s].
        tracked: survived and the mean velocity is close enough to the mean command from then on.
    """

    survived: np.ndarray
    squared_error: np.ndarray
    squared_error_steady: np.ndarray
    mean_velocity: np.ndarray
    tracked: np.ndarray


def tracking(
    recording: Recording, steady_from: float, tolerance: float, relative: float
) -> Tracking:
    """Velocity tracking; tracked means |mean v − command| ≤ max(tolerance, relative·|command|).

    The command is the forward one; where it changes, its mean from ``steady_from`` on counts.
    """
    first = round(steady_from / recording.period)
    survived = recording.survived
    forward = recording.velocity[:, :, 0]
    command = recording.command[:, :, 0]
    error = (forward - command) ** 2
    mean = forward[first:].mean(axis=0)
    wanted = command[first] + (command[first:] - command[first]).mean(axis=0)  # exact if constant
    allowed = np.maximum(tolerance, relative * np.abs(wanted))
    return Tracking(
        survived=survived,
        squared_error=_where(survived, error.mean(axis=0)),
        squared_error_steady=_where(survived, error[first:].mean(axis=0)),
        mean_velocity=_where(survived, mean),
        tracked=survived & (np.abs(mean - wanted) <= allowed),
    )


@dataclass(frozen=True)
class GaitQuality:
    """How a robot walks, per robot (N,), from ``steady_from`` on; NaN where a robot fell.

    Attributes:
        flight: share of time with no foot on the ground.
        double_support: share of time with both feet on the ground.
        touchdown_rate: touchdowns per second, both feet.
        alternation: share of touchdowns that follow one of the other foot; two feet that touch down
            together follow none.
        clearance: mean over feet of the 90th percentile over time of the sole's height [m], which
            counts as 0 while the foot is loaded.
        slip: mean horizontal speed of soles while loaded [m/s].
        heading: largest |yaw − commanded yaw| [rad] of the whole rollout; what is commanded is the
            yaw at the start and the integral of the commanded yaw rate.
        asymmetry: |mean time from a left to the next right touchdown − from right to left| over
            their sum, where a foot that touches down several times in a row counts with the first;
            1 where the feet do not alternate.
        velocity_variance: of the forward velocity about its mean [m²/s²].
        cost_of_transport: mean absolute power of the drives over m g and the mean speed [-].
        peak_effort, peak_speed: largest share of a drive's limit [-].
    """

    flight: np.ndarray
    double_support: np.ndarray
    touchdown_rate: np.ndarray
    alternation: np.ndarray
    clearance: np.ndarray
    slip: np.ndarray
    heading: np.ndarray
    asymmetry: np.ndarray
    velocity_variance: np.ndarray
    cost_of_transport: np.ndarray
    peak_effort: np.ndarray
    peak_speed: np.ndarray


def gait_quality(recording: Recording, steady_from: float) -> GaitQuality:
    """Quality of the gait from contacts and foot motion."""
    first = round(steady_from / recording.period)
    survived = recording.survived
    contact = recording.foot_forces[first:] > CONTACT_FORCE
    touchdown = contact[1:] & ~contact[:-1]
    seconds = len(touchdown) * recording.period
    return GaitQuality(
        flight=_where(survived, (~contact.any(axis=2)).mean(axis=0)),
        double_support=_where(survived, contact.all(axis=2).mean(axis=0)),
        touchdown_rate=_where(survived, touchdown.sum(axis=(0, 2)) / seconds),
        alternation=_where(survived, _alternation(touchdown)),
        clearance=_where(survived, _clearance(recording.foot_positions[first:], contact)),
        slip=_where(survived, _slip(recording.foot_positions[first:], contact, recording.period)),
        heading=_where(survived, np.abs(heading_error(recording)).max(axis=0)),
        asymmetry=_where(survived, _asymmetry(touchdown)),
        velocity_variance=_where(survived, recording.velocity[first:, :, 0].var(axis=0)),
        cost_of_transport=_where(survived, _cost_of_transport(recording, first)),
        peak_effort=_where(survived, recording.effort_share[first:].max(axis=0)),
        peak_speed=_where(survived, recording.speed_share[first:].max(axis=0)),
    )


def heading_error(recording: Recording) -> np.ndarray:
    """Yaw less the commanded yaw (S, N) [rad], both from the first step on."""
    turned = np.unwrap(recording.yaw, axis=0) - recording.yaw[0]
    commanded = np.cumsum(recording.command[:, :, 2], axis=0) * recording.period
    return turned - (commanded - commanded[0])


def _where(survived: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.where(survived, values, np.nan)


def _alternation(touchdown: np.ndarray) -> np.ndarray:
    """Share of touchdowns (S, N, 2) that follow one of the other foot (N,)."""
    share = np.zeros(touchdown.shape[1])
    for robot in range(touchdown.shape[1]):
        steps, feet = np.nonzero(touchdown[:, robot])
        if len(feet) > 1:
            together = touchdown[steps[1:], robot].all(axis=1)
            share[robot] = np.mean((feet[1:] != feet[:-1]) & ~together)
    return share


def _asymmetry(touchdown: np.ndarray) -> np.ndarray:
    """Of the step times (N,), from the first of touchdowns (S, N, 2) of a foot in a row."""
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
    """Infinite for a robot that stays where it is."""
    speed = np.abs(recording.velocity[first:, :, 0].mean(axis=0))
    power = recording.power[first:].mean(axis=0) / recording.weight
    return np.divide(power, speed, out=np.full_like(power, np.inf), where=speed > 0)


def _clearance(positions: np.ndarray, contact: np.ndarray) -> np.ndarray:
    heights = np.where(contact, 0.0, positions[..., 2])
    return np.percentile(heights, 90, axis=0).mean(axis=1)


def _slip(positions: np.ndarray, contact: np.ndarray, period: float) -> np.ndarray:
    speed = np.linalg.norm(np.diff(positions[..., :2], axis=0), axis=-1) / period
    loaded = contact[1:] & contact[:-1]
    return (speed * loaded).sum(axis=(0, 2)) / np.maximum(loaded.sum(axis=(0, 2)), 1)
