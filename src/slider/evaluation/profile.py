"""A command that changes during a rollout: its time series and the windows that count."""

import numpy as np

from slider.config.evaluation import CaseConfig, Segment


def commands(case: CaseConfig, ramp: float, duration: float, period: float) -> np.ndarray:
    """Commands (S, 3) vx, vy [m/s], yaw rate [rad/s] of each control ``period`` [s].

    Constant in each segment but for its first ``ramp`` seconds, which lead linearly from the
    command before to its own.
    """
    times = period * np.arange(round(duration / period))
    values = np.array([command(segment) for segment in case.segments])
    starts = np.array([segment.time for segment in case.segments])
    current = np.searchsorted(starts, times + period / 2, side="right") - 1
    before = values[np.maximum(current - 1, 0)]
    since = times - starts[current]
    share = np.ones_like(since) if ramp == 0.0 else np.clip(since / ramp, 0.0, 1.0)
    return before + share[:, None] * (values[current] - before)


def windows(case: CaseConfig, warm_up: float, duration: float, period: float) -> list[slice]:
    """Control steps of each segment but for its first ``warm_up`` seconds."""
    starts = [segment.time for segment in case.segments]
    ends = [*starts[1:], duration]
    return [
        slice(round((start + warm_up) / period), round(end / period))
        for start, end in zip(starts, ends, strict=True)
    ]


def command(segment: Segment) -> tuple[float, float, float]:
    """vx, vy [m/s] and yaw rate [rad/s] of a segment."""
    return segment.vx, segment.vy, segment.yaw_rate
