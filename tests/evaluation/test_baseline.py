"""The stage ``baseline``: the policy's protocol on torque drives."""

from dataclasses import replace

import numpy as np

from slider.config.convert import to_dict
from slider.config.evaluation import at_speed
from slider.core.job import Job
from slider.evaluation import stage
from slider.evaluation.results import Evaluation
from tests.env.synthetic import config

PROTOCOL = ("experiment=test", "evaluation.duration=0.6")


def section(controller: str = "mpc_wbc_tuned", **changes) -> dict:
    whole = config(*PROTOCOL)
    env = to_dict(whole.env)
    return {
        "robot": to_dict(whole.robot),
        "plant": {name: env[name] for name in ("control_period", "physics", "termination")},
        "control": to_dict(whole.control[controller]),
        "evaluation": to_dict(replace(whole.evaluation, **changes)),
        "controller": controller,
        "case": to_dict(at_speed(0.2)),
    }


def run(out, controller: str = "mpc_wbc_tuned", **changes):
    out.mkdir()
    return stage.run(section(controller, **changes), {}, out, Job(out.parent))


WALK = {"duration": 3.0, "warm_up": 1.4}  # [s]; from there on whole strides


def test_walks_and_its_records_are_those_of_the_policy(tmp_path):
    """The literal settings take a command of 0.2 m/s as the speed at the end of a step."""
    controller = "mpc_wbc_literal"
    summary = run(tmp_path / "out", controller, duration=4.0, warm_up=2.4)
    found = Evaluation.load(tmp_path / "out")
    assert len(found.robots) == 6
    assert summary["success_rate"] == 1.0
    assert summary["controller"] == found.controller == controller
    np.testing.assert_allclose(found.robots["mean_velocity"], 0.167, atol=0.03)
    np.testing.assert_array_equal(found.robots["alternation"], 1.0)
    step = config(*PROTOCOL).control[controller].step
    np.testing.assert_allclose(found.robots["touchdown_rate"], 1 / step.time, atol=0.7)


def test_walks_disturbed_robots(tmp_path):
    """Noise, 5 ms of delay, another robot than the nominal model."""
    overrides = ("evaluation=robust", "evaluation.disturbance.delay={lower: 0.005, upper: 0.005}")
    disturbance = config(*overrides).evaluation.disturbance
    calm = run(tmp_path / "calm", **WALK)
    rough = run(tmp_path / "rough", disturbance=disturbance, **WALK)
    assert rough["success_rate"] == 1.0
    assert calm["mse_steady"] < 0.001 < rough["mse_steady"] < 0.02
