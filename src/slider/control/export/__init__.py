"""A policy for use without this package: networks, layout, reference, robot in one folder."""

POLICY = "policy.pt"
ONNX = "policy.onnx"
TORCH_EXPORT = "policy.pt2"
LAYOUT = "policy.json"
MODEL = "robot.xml"
REFERENCE = "reference.npy"
FILES = (POLICY, ONNX, TORCH_EXPORT, LAYOUT, MODEL, REFERENCE)
