"""Watch the robot: a policy, a gait of the library, or an agent that checks the environment."""
