"""Segments of a changing velocity: its time series, records per robot and traces over time."""

import numpy as np
import pandas as pd

from slider.config.evaluation import CaseConfig, EvaluationConfig, ProfileConfig
from slider.env.instruments import in_contact, landings
from slider.env.metrics import heading_error
from slider.env.rollout import Recording
from slider.evaluation.results import AXES, MEASURES, SEGMENT_COLUMNS, places

SMOOTHING = 1.0  # averaging over this time, more than a stride in place, removes the sway [s]


def velocities(case: CaseConfig, ramp: float, duration: float, period: float) -> np.ndarray:
    """Velocities (S, 3): vx, vy [m/s], yaw rate [rad/s] of each control ``period`` [s].

    Constant in each segment except for its first ``ramp`` seconds, which interpolate linearly from
    the velocity of the previous segment.
    """
    times = period * np.arange(round(duration / period))
    values = np.array([[getattr(one, axis) for axis in AXES] for one in case.segments])
    starts = np.array([segment.time for segment in case.segments])
    current = np.searchsorted(starts, times + period / 2, side="right") - 1
    previous = values[np.maximum(current - 1, 0)]
    since = times - starts[current]
    share = np.ones_like(since) if ramp == 0.0 else np.clip(since / ramp, 0.0, 1.0)
    return previous + share[:, None] * (values[current] - previous)


def windows(case: CaseConfig, warm_up: float, duration: float, period: float) -> list[slice]:
    """Control steps of each segment without its first ``warm_up`` seconds."""
    starts = [segment.time for segment in case.segments]
    ends = [*starts[1:], duration]
    return [
        slice(round((start + warm_up) / period), round(end / period))
        for start, end in zip(starts, ends, strict=True)
    ]


def measure(recording: Recording, protocol: EvaluationConfig, case: CaseConfig) -> pd.DataFrame:
    """Rows of the robots in each segment with their ``MEASURES``.

    A robot survives a segment if it is up until its end, even if it falls later.
    """
    warm_up = profile_of(protocol).warm_up
    steps = windows(case, warm_up, protocol.duration, recording.period)
    contact = in_contact(recording.contacts.forces, recording.timestep)
    count = landings(contact).sum(axis=2)
    # In each control step, of both feet (S, N).
    touchdown = count.reshape(len(recording.alive), -1, count.shape[1]).sum(axis=1)
    parts = []
    for index, window in enumerate(steps):
        survived = recording.alive[window.stop - 1]
        part = places(protocol.trials, protocol.robots)
        part |= {"segment": np.full(len(survived), index), "survived": survived}
        values = pd.DataFrame(part | _measures(recording, touchdown, window))
        values.loc[~survived, list(MEASURES)] = np.nan
        parts.append(values[list(SEGMENT_COLUMNS)])
    return pd.concat(parts, ignore_index=True)


def _measures(recording: Recording, touchdown: np.ndarray, window: slice) -> dict[str, np.ndarray]:
    seconds = (window.stop - window.start) * recording.period
    velocity, command = _velocities(recording)[window], recording.command[window]
    position = recording.position[window]
    means = velocity.mean(axis=0)
    errors = np.abs(means - command.mean(axis=0))
    return {
        **dict(zip(AXES, means.T, strict=True)),
        **{f"{axis}_error": errors[:, i] for i, axis in enumerate(AXES)},
        "vx_mse": ((velocity[:, :, 0] - command[:, :, 0]) ** 2).mean(axis=0),
        "heading_error": np.abs(heading_error(recording)[window]).max(axis=0),
        "touchdown_rate": touchdown[window].sum(axis=0) / seconds,
        "displacement": np.linalg.norm(position[-1] - position[0], axis=1),
        "fastest": _fastest(recording.velocity[window], recording.period),
    }


def _fastest(velocity: np.ndarray, period: float) -> np.ndarray:
    """Largest speed (N,) of means of (S, N, 2) over ``SMOOTHING``, or over all of it if shorter."""
    width = min(len(velocity), max(1, round(SMOOTHING / period)))
    means = _moving_average(velocity, width)
    full = means[width // 2 : len(velocity) - (width + 1) // 2 + 1]
    return np.linalg.norm(full, axis=2).max(axis=0)


def traces(recording: Recording, protocol: EvaluationConfig) -> np.ndarray:
    """Time series of the command, of mean and spread over the robots that are up, and their share.

    Returns:
        (S, 10) float32: commanded vx, vy, yaw rate; means of the three, their standard deviations
        between robots, both of moving averages over ``profile.window``; share of these robots.
    """
    width = max(1, round(profile_of(protocol).window / recording.period))
    alive = recording.alive[:, :, None]
    upright = _moving_average(alive.astype(float), width)  # samples after a fall do not count
    smooth = _moving_average(np.where(alive, _velocities(recording), 0.0), width)
    smooth = smooth / np.maximum(upright, 1.0 / width)
    count = np.maximum(alive.sum(axis=1), 1)
    mean = np.where(alive, smooth, 0.0).sum(axis=1) / count
    square = (np.where(alive, smooth - mean[:, None], 0.0) ** 2).sum(axis=1) / count
    lost = ~recording.alive.any(axis=1)
    mean[lost] = square[lost] = np.nan
    share = recording.alive.mean(axis=1)[:, None]
    columns = [recording.command[:, 0], mean, np.sqrt(square), share]
    return np.concatenate(columns, axis=1).astype(np.float32)


def _velocities(recording: Recording) -> np.ndarray:
    """Forward and leftward velocity and yaw rate (S, N, 3)."""
    yaw = np.unwrap(recording.yaw, axis=0)
    rate = np.diff(yaw, axis=0, prepend=yaw[:1]) / recording.period
    return np.concatenate([recording.velocity, rate[:, :, None]], axis=2)


def _moving_average(values: np.ndarray, width: int) -> np.ndarray:
    """Centred, over at most ``width`` samples of the first axis."""
    total = np.cumsum(np.concatenate([np.zeros_like(values[:1]), values]), axis=0)
    index = np.arange(len(values))
    first = np.maximum(index - width // 2, 0)
    last = np.minimum(index + (width + 1) // 2, len(values))
    return (total[last] - total[first]) / (last - first)[:, None, None]


def profile_of(protocol: EvaluationConfig) -> ProfileConfig:
    """The profile of a protocol that has one."""
    assert protocol.profile is not None
    return protocol.profile
