"""What the motors do, at every simulation step: their peaks fall between control steps."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from slider.robot.transmission import Transmission


class DriveLoads(NamedTuple):
    """Loads of N robots over some simulation steps.

    Attributes:
        power: (N,) mechanical power, absolute values of the motors added, mean over the steps [W].
        effort_share: (N,) largest torque of a motor as a share of its limit [-].
        speed_share: (N,) largest speed of a motor as a share of its no-load speed [-].
    """

    power: np.ndarray
    effort_share: np.ndarray
    speed_share: np.ndarray


def loads(motors: Transmission, torques: np.ndarray, speeds: np.ndarray) -> DriveLoads:
    """Of motor torques [N m] and the motor speeds [rad/s] they lead to (N, steps, 10)."""
    torque, speed = np.abs(torques), np.abs(speeds)
    return DriveLoads(
        power=(torque * speed).sum(axis=2).mean(axis=1),
        effort_share=(torque / motors.torque).max(axis=(1, 2)),
        speed_share=(speed / motors.speed).max(axis=(1, 2)),
    )


def over(loads: Sequence[DriveLoads]) -> DriveLoads:
    """Loads over equally long stretches of time, one after the other."""
    power, effort, speed = (np.stack(column) for column in zip(*loads, strict=True))
    return DriveLoads(power.mean(axis=0), effort.max(axis=0), speed.max(axis=0))
