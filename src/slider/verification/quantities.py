"""Name, unit and meaning of every verified quantity, one number per gait."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Checked:
    """One number per gait.

    Attributes:
        check: number of the check in ``docs/reference/verification.md``.
        at_least: whether the bound is a lower one, so that small values are bad.
    """

    check: int
    title: str
    unit: str
    at_least: bool = False

    def limit(self, bound: float) -> str:
        """A bound with its inequality sign."""
        return f"{'≥' if self.at_least else '≤'} {bound:g}"


def worst(rows: Sequence[Mapping[str, ArrayLike]]) -> dict[str, float]:
    """Greatest magnitude of each quantity; NaN where there is one."""
    return {name: float(np.abs(np.array([row[name] for row in rows])).max()) for name in rows[0]}


QUANTITIES: dict[str, Checked] = {
    "dynamics_torque": Checked(1, "stored torques of the knee's joints against pinocchio's", "N m"),
    "dynamics_efforts": Checked(
        1, "stored efforts of the slide's joints against pinocchio's", "N m, N"
    ),
    "dynamics_base": Checked(
        1, "residual wrench on the base under the stored ground wrench", "N, N m"
    ),
    "dynamics_line_moment": Checked(
        1, "stored moment about the foot line or the ankle's roll", "N m"
    ),
    "impact_velocity": Checked(2, "velocities after a plastic impact", "rad/s, m/s"),
    "impact_impulse": Checked(2, "impulsive torques that the stored velocities need", "N m s"),
    "mean_velocity": Checked(3, "displacement over the walk against the velocity", "m/s"),
    "periodicity": Checked(3, "jump of joints and base at the touchdowns", "rad, m"),
    "roll_end": Checked(4, "collocated roll against DOP853 at the end of a step", "rad"),
    "roll_rate_end": Checked(
        4, "collocated roll rate against DOP853 at the end of a step", "rad/s"
    ),
    "roll_worst": Checked(4, "collocated roll against DOP853 at all nodes", "rad"),
    "plant_force": Checked(
        5, "residual force on MuJoCo's base under the stored ground wrench", "N"
    ),
    "plant_moment": Checked(5, "residual moment on MuJoCo's base under that wrench", "N m"),
    "plant_efforts": Checked(5, "stored efforts against MuJoCo's", "N m, N"),
    "plant_cop": Checked(5, "centre of pressure as a share of the foot, by MuJoCo", "-"),
    "plant_torque": Checked(5, "motor torques as a share of their limits, by MuJoCo", "-"),
    "plant_voltage": Checked(5, "motor voltages as a share of the bus, by MuJoCo", "-"),
    "plant_impact": Checked(5, "velocities after MuJoCo's plastic impact", "rad/s, m/s"),
    "dense_penetration": Checked(6, "toe or heel of the swing foot below the ground", "m"),
    "dense_clearance": Checked(6, "toe or heel below the parabola of gait.posture", "m"),
    "dense_cop": Checked(6, "centre of pressure as a share of the foot", "-"),
    "dense_friction": Checked(6, "friction coefficient that the foot needs", "-"),
    "dense_torque": Checked(6, "motor torques as a share of their limits", "-"),
    "dense_voltage": Checked(6, "motor voltages as a share of the bus", "-"),
    "dense_position": Checked(6, "prismatic joints beyond their range", "rad, m"),
    "dense_leg_distance": Checked(
        6, "least distance of one leg from the other", "m", at_least=True
    ),
}
