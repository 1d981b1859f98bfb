"""What is verified: the name, unit and meaning of every quantity, one number per gait."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """One number per gait.

    Attributes:
        check: number of the check in ``docs/verification.md``.
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
    "dynamics_torque": Quantity(1, "N m", "stored joint torques against pinocchio's"),
    "dynamics_efforts": Quantity(1, "N m, N", "stored efforts against virtual work"),
    "dynamics_base": Quantity(1, "N, N m", "what the stored ground wrench leaves on the base"),
    "dynamics_line_moment": Quantity(1, "N m", "stored moment about the foot line"),
    "impact_velocity": Quantity(2, "rad/s, m/s", "velocities after a plastic impact"),
    "impact_impulse": Quantity(2, "N m s", "impulsive torques that the stored velocities need"),
    "mean_velocity": Quantity(3, "m/s", "displacement over the walk against the command"),
    "periodicity": Quantity(3, "rad, m", "jump of joints and base at the touchdowns"),
    "roll_end": Quantity(4, "rad", "collocated roll against DOP853 at the end of a step"),
    "roll_rate_end": Quantity(4, "rad/s", "the same for the roll rate"),
    "roll_worst": Quantity(4, "rad", "collocated roll against DOP853 at all nodes"),
    "mirror_distance": Quantity(5, "rad, m", "joints against the reflected gait of -vy"),
    "mirror_cost": Quantity(5, "-", "relative difference in cost from the gait of -vy"),
    "return_map": Quantity(6, "-", "greatest modulus of the open loop's eigenvalues, per walk"),
    "return_map_least": Quantity(6, "-", "least modulus of the open loop's eigenvalues"),
    "replay_steps": Quantity(7, "1", "steps of the replay by joint targets alone", True),
    "replay_speed": Quantity(7, "m/s", "error of its mean velocity"),
    "regulated_steps": Quantity(7, "1", "steps of the replay with foot placement", True),
    "regulated_speed": Quantity(7, "m/s", "error of its mean velocity"),
    "wrench_force_exact": Quantity(8, "N", "rms force left on the prismatic robot's base"),
    "wrench_moment_exact": Quantity(8, "N m", "rms moment left on it"),
    "wrench_force_paper": Quantity(8, "N", "the same with eq. 1 as printed"),
    "wrench_moment_paper": Quantity(8, "N m", "the same with eq. 1 as printed"),
    "dense_penetration": Quantity(9, "m", "toe or heel of the swing foot below the ground"),
    "dense_clearance": Quantity(9, "m", "toe or heel below the wanted parabola"),
    "dense_cop": Quantity(9, "-", "centre of pressure as a share of toe or heel length"),
    "dense_friction": Quantity(9, "-", "friction coefficient that the foot needs"),
    "dense_friction_ends": Quantity(9, "-", "friction coefficient that toe or heel needs alone"),
    "dense_torque": Quantity(9, "-", "rotary efforts as a share of their limits"),
    "dense_slide_force": Quantity(9, "-", "slide force as a share of its limit"),
    "dense_speed": Quantity(9, "-", "rotary speeds as a share of their limits"),
    "dense_slide_speed": Quantity(9, "-", "slide speed as a share of its limit"),
    "dense_position": Quantity(9, "rad, m", "prismatic joints beyond their range"),
    "dense_roll_defect": Quantity(9, "rad/s²", "roll acceleration against the dynamics"),
    "jump_samples": Quantity(10, "-", "jump to a neighbour per 0.05 m/s, share of range"),
    "jump_coefficients": Quantity(10, "-", "the same for Bézier coefficients"),
}
