"""Parameters, joint names and models of the robot."""
