"""The exported graph in the oldest and newest onnxruntime of docs/reference/policy.md."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import onnxruntime
import pytest

from slider.control.deployment import policy_step
from tests.control.policies import make_policy
from tests.control.test_deployment import graph, readings

PAGE = Path(__file__).parents[2] / "docs/reference/policy.md"
VERSIONS = re.search(r"onnxruntime (1\.\d+\.\d+)\s+to\s+(1\.\d+\.\d+)", PAGE.read_text()).groups()
REPLAY = """
import sys, numpy, onnxruntime
session = onnxruntime.InferenceSession("policy.onnx", providers=["CPUExecutionProvider"])
given, targets = numpy.load("readings.npz"), []
state = numpy.zeros((1, session.get_inputs()[-1].shape[1]))
for step in range(500):
    feeds = {name: given[name][step] for name in given}
    found, state = session.run(None, {**feeds, "state": state})
    targets.append(found)
numpy.save(onnxruntime.__version__, targets)
"""


@pytest.mark.faults
@pytest.mark.parametrize("version", VERSIONS)
def test_ten_seconds_in_another_runtime(version, tmp_path):
    step = policy_step(make_policy())
    graph(step, tmp_path / "policy.onnx")
    rows = [readings(step, seed) for seed in range(500)]
    given = {name: np.stack([row[name] for row in rows]) for name in step.readings}
    given["command"][:] = [0.3, 0.0, 0.0]
    np.savez(tmp_path / "readings.npz", **given)
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    other, numbers = tmp_path / "venv/bin/python", "numpy<2" if version < "1.19" else "numpy"
    wanted = [f"onnxruntime=={version}", numbers]
    subprocess.run([other, "-m", "pip", "install", "--quiet", *wanted], check=True)
    for python in (sys.executable, other):
        subprocess.run([python, "-c", REPLAY], cwd=tmp_path, check=True)
    ours, theirs = (np.load(tmp_path / f"{v}.npy") for v in (onnxruntime.__version__, version))
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-6)
