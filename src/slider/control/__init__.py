"""Controllers of the robot: the learned policy and the model-based ones."""

POLICY_FILE = "policy.pt"  # of a training
ONNX = "policy.onnx"
ESTIMATOR = "estimator.onnx"
LAYOUT = "policy.json"
MODEL = "robot.xml"
EXPORT_FILES = (POLICY_FILE, ONNX, ESTIMATOR, LAYOUT, MODEL)
"""Files of a policy for use without this package."""
