"""A policy for use without this package: networks, layout, reference, robot in one folder."""

from slider.control import POLICY_FILE

ONNX = "policy.onnx"
TORCH_EXPORT = "policy.pt2"
LAYOUT = "policy.json"
MODEL = "robot.xml"
REFERENCE = "reference.npy"
FILES = (POLICY_FILE, ONNX, TORCH_EXPORT, LAYOUT, MODEL, REFERENCE)
