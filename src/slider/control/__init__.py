"""Controllers of the robot: the learned policy and the model-predictive ones."""

POLICY_FILE = "policy.pt"  # of a training
