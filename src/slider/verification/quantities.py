"""What is verified: the name, unit and meaning of every quantity, one number per gait."""

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


QUANTITIES: dict[str, Quantity] = {
    "kinematics_position": Quantity(
        1, "rad, m", "stored joints, base and feet against coefficients and a foot that rolls"
    ),
    "kinematics_velocity": Quantity(1, "rad/s, m/s", "the same for their velocities"),
    "kinematics_time": Quantity(1, "s", "stored times against the step times"),
    "kinematics_samples": Quantity(1, "rad, m, 1/s", "stored channels against eq. 1 and the base"),
    "dynamics_torque": Quantity(
        1, "N m", "stored torques of the knee's joints against pinocchio's"
    ),
    "dynamics_efforts": Quantity(1, "N m, N", "stored efforts of the slide's joints, the same"),
    "dynamics_base": Quantity(1, "N, N m", "what the stored ground wrench leaves on the base"),
    "dynamics_line_moment": Quantity(1, "N m", "stored moment about the foot line"),
    "impact_velocity": Quantity(2, "rad/s, m/s", "velocities after a plastic impact"),
    "impact_impulse": Quantity(2, "N m s", "impulsive torques that the stored velocities need"),
    "mean_velocity": Quantity(3, "m/s", "displacement over the walk against the command"),
    "periodicity": Quantity(3, "rad, m", "jump of joints and base at the touchdowns"),
    "roll_end": Quantity(4, "rad", "collocated roll against DOP853 at the end of a step"),
    "roll_rate_end": Quantity(4, "rad/s", "the same for the roll rate"),
    "roll_worst": Quantity(4, "rad", "collocated roll against DOP853 at all nodes"),
    "mirror_distance": Quantity(
        5, "rad, m", "joints against the reflected gait of -vy and -yaw rate"
    ),
    "mirror_cost": Quantity(5, "-", "relative difference in cost from that gait"),
    "return_map": Quantity(6, "-", "greatest modulus of the open loop's eigenvalues, per walk"),
    "return_map_least": Quantity(6, "-", "least modulus of the open loop's eigenvalues"),
    "replay_steps": Quantity(7, "1", "steps of the replay by joint targets alone", True),
    "replay_speed": Quantity(7, "m/s", "error of its mean velocity"),
    "regulated_steps": Quantity(7, "1", "steps of the replay with foot placement", True),
    "regulated_speed": Quantity(7, "m/s", "error of its mean velocity"),
    "plant_force": Quantity(8, "N", "force that the stored ground wrench leaves on MuJoCo's base"),
    "plant_moment": Quantity(8, "N m", "moment that it leaves there"),
    "plant_efforts": Quantity(8, "N m, N", "stored efforts against MuJoCo's"),
    "upper_foot_torque": Quantity(8, "N m", "what would hold an upper foot on its tube"),
    "plant_cop": Quantity(8, "-", "centre of pressure as a share of the foot, by MuJoCo"),
    "plant_torque": Quantity(8, "-", "motor torques as a share of their limits, by MuJoCo"),
    "plant_voltage": Quantity(8, "-", "motor voltages as a share of the bus, by MuJoCo"),
    "plant_impact": Quantity(8, "rad/s, m/s", "velocities after MuJoCo's plastic impact"),
    "plant_impact_free": Quantity(8, "rad/s, m/s", "the same with upper feet free to swing"),
    "dense_penetration": Quantity(9, "m", "toe or heel of the swing foot below the ground"),
    "dense_clearance": Quantity(9, "m", "toe or heel below the wanted parabola"),
    "dense_cop": Quantity(9, "-", "centre of pressure as a share of toe or heel length"),
    "dense_friction": Quantity(9, "-", "friction coefficient that the foot needs"),
    "dense_friction_ends": Quantity(9, "-", "friction coefficient that toe or heel needs alone"),
    "dense_torque": Quantity(9, "-", "motor torques as a share of their limits"),
    "dense_voltage": Quantity(9, "-", "motor voltages as a share of the bus"),
    "dense_position": Quantity(9, "rad, m", "prismatic joints beyond their range"),
    "dense_leg_distance": Quantity(9, "m", "least distance of one leg from the other", True),
    "dense_roll_defect": Quantity(9, "rad/s²", "roll acceleration against the dynamics"),
    "jump_samples": Quantity(10, "-", "jump to a neighbour per 0.05 m/s, share of range"),
    "jump_coefficients": Quantity(10, "-", "the same for Bézier coefficients"),
}
