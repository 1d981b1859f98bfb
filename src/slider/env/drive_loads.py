"""What the drives do, at every simulation step: their peaks fall between control steps."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from slider.core.config.robot import RobotConfig
from slider.robot.names import ACTUATED, JOINTS


class DriveLoads(NamedTuple):
    """Loads of N robots over some simulation steps.

    Attributes:
        power: (N,) mechanical power, absolute values of the drives added, mean over the steps [W].
        effort_share: (N,) largest effort of a drive as a share of its limit [-].
        speed_share: (N,) largest speed of a drive as a share of its limit [-].
    """

    power: np.ndarray
    effort_share: np.ndarray
    speed_share: np.ndarray


class DriveLimits:
    """Effort and speed limits of the joints with a drive."""

    def __init__(self, robot: RobotConfig) -> None:
        driven = [robot.limits[JOINTS[i].split("_", 1)[1]] for i in ACTUATED]
        self._effort = np.array([limit.effort for limit in driven])
        self._speed = np.array([limit.speed for limit in driven])

    def loads(self, efforts: np.ndarray, speeds: np.ndarray) -> DriveLoads:
        """Of efforts [N m or N] and the speeds [rad/s or m/s] they lead to (N, steps, 10)."""
        effort, speed = np.abs(efforts), np.abs(speeds)
        return DriveLoads(
            power=(effort * speed).sum(axis=2).mean(axis=1),
            effort_share=(effort / self._effort).max(axis=(1, 2)),
            speed_share=(speed / self._speed).max(axis=(1, 2)),
        )


def over(loads: Sequence[DriveLoads]) -> DriveLoads:
    """Loads over equally long stretches of time, one after the other."""
    power, effort, speed = (np.stack(column) for column in zip(*loads, strict=True))
    return DriveLoads(power.mean(axis=0), effort.max(axis=0), speed.max(axis=0))
