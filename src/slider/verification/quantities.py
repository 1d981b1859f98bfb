"""Name, unit and meaning of every verified quantity, one number per gait."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """One number per gait.

    Attributes:
        check: number of the check in ``docs/reference/verification.md``.
        unit, meaning: for reports.
        at_least: the bound is a lower one, and small values are the bad ones.
    """

    check: int
    unit: str
    meaning: str
    at_least: bool = False

    def limit(self, bound: float) -> str:
        """A bound with its sense."""
        return f"{'≥' if self.at_least else '≤'} {bound:g}"


QUANTITIES: dict[str, Quantity] = {
    "dynamics_torque": Quantity(
        1, "N m", "stored torques of the knee's joints against pinocchio's"
    ),
    "dynamics_efforts": Quantity(1, "N m, N", "stored efforts of the slide's joints, the same"),
    "dynamics_base": Quantity(1, "N, N m", "what the stored ground wrench leaves on the base"),
    "dynamics_line_moment": Quantity(1, "N m", "stored moment about the foot line"),
    "impact_velocity": Quantity(2, "rad/s, m/s", "velocities after a plastic impact"),
    "impact_impulse": Quantity(2, "N m s", "impulsive torques that the stored velocities need"),
    "mean_velocity": Quantity(3, "m/s", "displacement over the walk against the velocity"),
    "periodicity": Quantity(3, "rad, m", "jump of joints and base at the touchdowns"),
    "roll_end": Quantity(4, "rad", "collocated roll against DOP853 at the end of a step"),
    "roll_rate_end": Quantity(4, "rad/s", "the same for the roll rate"),
    "roll_worst": Quantity(4, "rad", "collocated roll against DOP853 at all nodes"),
    "plant_force": Quantity(5, "N", "force that the stored ground wrench leaves on MuJoCo's base"),
    "plant_moment": Quantity(5, "N m", "moment that it leaves there"),
    "plant_efforts": Quantity(5, "N m, N", "stored efforts against MuJoCo's"),
    "plant_cop": Quantity(5, "-", "centre of pressure as a share of the foot, by MuJoCo"),
    "plant_torque": Quantity(5, "-", "motor torques as a share of their limits, by MuJoCo"),
    "plant_voltage": Quantity(5, "-", "motor voltages as a share of the bus, by MuJoCo"),
    "plant_impact": Quantity(5, "rad/s, m/s", "velocities after MuJoCo's plastic impact"),
    "dense_penetration": Quantity(6, "m", "toe or heel of the swing foot below the ground"),
    "dense_clearance": Quantity(6, "m", "toe or heel below the parabola of gait.posture"),
    "dense_cop": Quantity(6, "-", "centre of pressure as a share of toe or heel length"),
    "dense_friction": Quantity(6, "-", "friction coefficient that the foot needs"),
    "dense_torque": Quantity(6, "-", "motor torques as a share of their limits"),
    "dense_voltage": Quantity(6, "-", "motor voltages as a share of the bus"),
    "dense_position": Quantity(6, "rad, m", "prismatic joints beyond their range"),
    "dense_leg_distance": Quantity(6, "m", "least distance of one leg from the other", True),
}
