"""The quantities of evaluations and gaits that reports show, by the names of their columns."""

from slider.core.quantities import Quantity


def _share(title: str, of: str = "") -> Quantity:
    return Quantity(title, f"% {of}".strip(), 100.0)


QUANTITIES = {
    "success_rate": _share("Success rate"),
    "mse_steady": Quantity("Velocity MSE after the warm-up", "m²/s²"),
    "mse": Quantity("Velocity MSE of the whole trial, start from rest included", "m²/s²"),
    "tracking_rate": _share("Tracking rate"),
    "standing_rate": _share("Standing"),
    "mean_velocity": Quantity("Mean velocity", "m/s"),
    "flight": _share("Flight", "of time"),
    "double_support": _share("Double support", "of time"),
    "touchdown_rate": Quantity("Touchdowns", "1/s"),
    "contact_rate": Quantity("Contacts that begin, bounces counted", "1/s"),
    "reference_touchdown_rate": Quantity("Touchdowns of the library's gait", "1/s"),
    "alternation": _share("Touchdowns that follow one of the other foot"),
    "clearance": Quantity("Foot clearance", "cm", 100.0),
    "slip": Quantity("Slip of loaded heels and toes", "cm/s", 100.0),
    "penetration": Quantity("Depth of loaded feet in the ground", "mm", 1000.0),
    "penetration_max": Quantity("Greatest depth of a loaded foot, worst robot", "mm", 1000.0),
    "heading": Quantity("Largest heading error, mean of the robots", "rad"),
    "heading_worst": Quantity("Largest heading error, worst robot", "rad"),
    "asymmetry": _share("Asymmetry of step times"),
    "velocity_variance": Quantity("Variance of the forward velocity", "m²/s²"),
    "reference_velocity_variance": Quantity("Variance of the library's gait", "m²/s²"),
    "cost_of_transport": Quantity("Cost of transport", "-"),
    "peak_effort": _share("Peak motor torque, worst robot", "of its limit"),
    "peak_speed": _share("Peak motor speed, worst robot", "of its limit"),
    "leg_distance": Quantity("Least distance of the legs, worst robot", "cm", 100.0),
    "legs_touch": _share("Legs touch", "of time"),
    "robots_touch": _share("Robots whose legs ever touch"),
    "legs_cross": _share("Feet cross", "of time"),
    "robots_cross": _share("Robots whose feet ever cross"),
    "estimate_vx": Quantity("Error of the estimated forward velocity, RMS", "cm/s", 100.0),
    "estimate_vy": Quantity("Error of the estimated leftward velocity, RMS", "cm/s", 100.0),
    "estimate_height": Quantity("Error of the estimated height, RMS", "cm", 100.0),
    "estimate_tilt": Quantity("Error of the measured tilt, RMS", "rad"),
    "vx": Quantity("Mean vx", "m/s"),
    "vy": Quantity("Mean vy", "m/s"),
    "vx_error": Quantity("Error of vx", "m/s"),
    "vy_error": Quantity("Error of vy", "m/s"),
    "vx_mse": Quantity("MSE of vx", "m²/s²"),
    "yaw_rate_error": Quantity("Error of yaw rate", "rad/s"),
    "heading_error": Quantity("Largest heading error", "rad"),
    "displacement": Quantity("Displacement", "m"),
    "fastest": Quantity("Fastest robot", "m/s"),
    "drift": Quantity("Drift, mean", "m"),
    "drift_max": Quantity("Drift, greatest", "m"),
    "samples_to_walk": Quantity("Samples until 95 % of a check's robots survive", "M", 1e-6),
}
GAIT_QUANTITIES = {
    "converged": _share("Gaits that converge"),
    "reaches_best": _share("Gaits that reach the least cost"),
    "cost": Quantity("Cost of the gait"),
    "cost_change": _share("Cost of the gait, change"),
    "cost_excess": _share("Cost above the least of all solutions"),
    "torque_cost": Quantity("(1/T) ∫ ‖τ‖² dt of both steps", "N² m²"),
    "torque_cost_change": _share("(1/T) ∫ ‖τ‖² dt of both steps, change"),
    "iterations": Quantity("Iterations of IPOPT"),
    "max_violation": Quantity("Worst residual at the nodes"),
    "step_time": Quantity("Step time", "s"),
    "gait_transport": Quantity("Cost of transport of the gait", "-"),
    "base_height": Quantity("Height of the base", "m"),
    "joints_difference": Quantity("Joints, from the reference", "rad"),
    "roll_difference": Quantity("Roll, from the reference", "rad"),
    "roll_end_difference": Quantity("Roll at the end, from the reference", "rad"),
    "between_foot_line_moment": Quantity("Roll equation between nodes", "N m"),
}
QUANTITIES |= GAIT_QUANTITIES


def quantity(name: str) -> Quantity:
    """The quantity of a column; an unlisted one has the column's name."""
    return QUANTITIES.get(name, Quantity(name))


OURS, PAPER = "measured", "paper"  # the column ``source`` of Table 1
PAPER_ROBOT = "slider"  # ``robot.name``
