"""Controllers of the robot: the learned policy and the model-based ones."""

POLICY_FILE = "policy.pt"  # of a training
ONNX = "policy.onnx"
LAYOUT = "policy.json"
MODEL = "robot.xml"
REFERENCE = "reference.npy"
EXPORT_FILES = (POLICY_FILE, ONNX, LAYOUT, MODEL, REFERENCE)
"""Files of a policy for use without this package."""
