"""A policy for use without this package: networks, layout and robot model in one folder."""

POLICY = "policy.pt"
ONNX = "policy.onnx"
TORCH_EXPORT = "policy.pt2"
LAYOUT = "policy.json"
MODEL = "robot.xml"
FILES = (POLICY, ONNX, TORCH_EXPORT, LAYOUT, MODEL)
