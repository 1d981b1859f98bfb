"""The exported graph in the oldest and newest onnxruntime of docs/reference/policy.md."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from slider.env.physics import BatchedPhysics
from slider.env.rollout import roll_out
from slider.env.starts import USUAL_NOISE, at_rest
from tests.control.policies import make_policy
from tests.control.test_deployment import both

PAGE = Path(__file__).parents[2] / "docs/reference/policy.md"
VERSIONS = re.search(r"onnxruntime (1\.\d+\.\d+)\s+to\s+(1\.\d+\.\d+)", PAGE.read_text()).groups()
REPLAY = """
import sys, numpy, onnxruntime
session = onnxruntime.InferenceSession(sys.argv[1], providers=["CPUExecutionProvider"])
given, worst = dict(numpy.load(sys.argv[2])), 0.0
targets, state = given.pop("targets"), numpy.zeros((1, session.get_inputs()[-1].shape[1]))
for step, expected in enumerate(targets):
    feeds = {name: values[step] for name, values in given.items()}
    found, state = session.run(None, {**feeds, "state": state})
    worst = max(worst, abs(found - expected).max())
print(onnxruntime.__version__, worst)
"""


@pytest.mark.faults
@pytest.mark.parametrize("version", VERSIONS)
def test_ten_seconds_in_another_runtime(version, tmp_path):
    policy = make_policy()
    controllers, rows = both(policy, tmp_path / "policy.onnx", 1), []
    session = controllers.exported._session

    class Noted:
        def run(self, names, feeds):
            rows.append({name: value for name, value in feeds.items() if name != "state"})
            return session.run(names, feeds)

    control = controllers.control

    def noted(state):
        targets = control(state)
        rows[-1]["targets"] = targets
        return targets

    controllers.exported._session, controllers.control = Noted(), noted
    physics = BatchedPhysics(policy.robot, policy.env.physics, 1)
    start = at_rest(policy.robot, USUAL_NOISE, np.random.default_rng(0), 1)
    roll_out(controllers, physics, policy.env, start, np.array([[0.3, 0.0, 0.0]]), 10.0)
    np.savez(tmp_path / "rows.npz", **{n: np.stack([row[n] for row in rows]) for n in rows[0]})
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    python, wanted = tmp_path / "venv/bin/python", f"onnxruntime=={version}"
    numbers = "numpy<2" if version < "1.19" else "numpy"
    subprocess.run([python, "-m", "pip", "install", "--quiet", wanted, numbers], check=True)
    command = [python, "-c", REPLAY, tmp_path / "policy.onnx", tmp_path / "rows.npz"]
    found, worst = subprocess.check_output(command, text=True).split()
    assert found == version
    assert float(worst) < 1e-6
