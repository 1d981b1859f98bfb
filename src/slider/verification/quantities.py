"""Name, unit and meaning of every verified quantity, one number per gait."""

from dataclasses import dataclass

from slider.core.quantities import Quantity


@dataclass(frozen=True)
class Checked(Quantity):
    """One number per gait.

    Attributes:
        check: number of the check in ``docs/reference/verification.md``.
        at_least: the bound is a lower one, and small values are the bad ones.
    """

    digits: str = ".3g"
    check: int = 0
    at_least: bool = False

    def limit(self, bound: float) -> str:
        """A bound with its sense."""
        return f"{'≥' if self.at_least else '≤'} {bound:g}"


QUANTITIES: dict[str, Checked] = {
    "dynamics_torque": Checked(
        "stored torques of the knee's joints against pinocchio's", "N m", check=1
    ),
    "dynamics_efforts": Checked(
        "stored efforts of the slide's joints, the same", "N m, N", check=1
    ),
    "dynamics_base": Checked("what the stored ground wrench leaves on the base", "N, N m", check=1),
    "dynamics_line_moment": Checked(
        "stored moment about the foot line or the ankle's roll", "N m", check=1
    ),
    "impact_velocity": Checked("velocities after a plastic impact", "rad/s, m/s", check=2),
    "impact_impulse": Checked(
        "impulsive torques that the stored velocities need", "N m s", check=2
    ),
    "mean_velocity": Checked("displacement over the walk against the velocity", "m/s", check=3),
    "periodicity": Checked("jump of joints and base at the touchdowns", "rad, m", check=3),
    "roll_end": Checked("collocated roll against DOP853 at the end of a step", "rad", check=4),
    "roll_rate_end": Checked("the same for the roll rate", "rad/s", check=4),
    "roll_worst": Checked("collocated roll against DOP853 at all nodes", "rad", check=4),
    "plant_force": Checked(
        "force that the stored ground wrench leaves on MuJoCo's base", "N", check=5
    ),
    "plant_moment": Checked("moment that it leaves there", "N m", check=5),
    "plant_efforts": Checked("stored efforts against MuJoCo's", "N m, N", check=5),
    "plant_cop": Checked("centre of pressure as a share of the foot, by MuJoCo", "-", check=5),
    "plant_torque": Checked("motor torques as a share of their limits, by MuJoCo", "-", check=5),
    "plant_voltage": Checked("motor voltages as a share of the bus, by MuJoCo", "-", check=5),
    "plant_impact": Checked("velocities after MuJoCo's plastic impact", "rad/s, m/s", check=5),
    "dense_penetration": Checked("toe or heel of the swing foot below the ground", "m", check=6),
    "dense_clearance": Checked("toe or heel below the parabola of gait.posture", "m", check=6),
    "dense_cop": Checked("centre of pressure as a share of the foot", "-", check=6),
    "dense_friction": Checked("friction coefficient that the foot needs", "-", check=6),
    "dense_torque": Checked("motor torques as a share of their limits", "-", check=6),
    "dense_voltage": Checked("motor voltages as a share of the bus", "-", check=6),
    "dense_position": Checked("prismatic joints beyond their range", "rad, m", check=6),
    "dense_leg_distance": Checked(
        "least distance of one leg from the other", "m", check=6, at_least=True
    ),
}
