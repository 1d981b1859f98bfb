"""Controllers of the robot: the learned policy."""
