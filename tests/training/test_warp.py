"""A training with MuJoCo Warp: the same networks, checks and files."""

from pathlib import Path

import pytest
import torch

from slider.config.convert import to_dict
from slider.config.evaluation import at_speed
from slider.control import POLICY_FILE
from slider.control.policy import load_policy
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.vec_env import task_of
from slider.evaluation import stage as evaluation
from slider.library.reader import STORE
from slider.training.selection import Selector
from slider.training.trainer import run_walking
from tests.env.synthetic import config
from tests.library.gaits import straight
from tests.training.test_stage import section
from tests.training.test_trainer import TINY

pytest.importorskip("mujoco_warp", reason="no extra gpu")

from slider.env.vec_env import WalkingEnv

WARP = (
    "train.walking.simulator=mujoco_warp",
    "train.walking.iterations=2",
    "train.walking.steps_per_iteration=4",
    "train.walking.seed=2",  # no episode ends in two iterations: equal columns
    "train/walking/disturbance=robust",
)


def settings() -> Section:
    return section(*WARP)


def train(work: Path, inputs: Inputs) -> tuple[Path, Job, Summary]:
    out, job = work / "out", Job(work)
    out.mkdir(parents=True, exist_ok=True)
    return out, job, run_walking(settings(), inputs, out, job)


def test_a_policy_of_warp_survives_a_kill_and_is_evaluated_as_any_other(tmp_path, monkeypatch):
    """Robots that vary and are pushed; all is computed with tensors."""
    seen, real = [], WalkingEnv.step

    def step(env: WalkingEnv, actions: torch.Tensor) -> tuple:
        seen.append(env.agent.command)
        if len(seen) == 8 + 6:
            raise KeyboardInterrupt
        return real(env, actions)

    monkeypatch.setattr(WalkingEnv, "step", step)
    inputs = {"library": [straight()]}
    whole, *_ = train(tmp_path / "whole", inputs)
    with pytest.raises(KeyboardInterrupt):
        train(tmp_path / "killed", inputs)
    out, job, facts = train(tmp_path / "killed", inputs)
    assert job.metadata["blow_ups"] == 0
    assert sorted(path.name for path in out.iterdir()) == sorted(p.name for p in whole.iterdir())
    for path in whole.iterdir():
        assert (out / path.name).read_bytes() == path.read_bytes(), path.name
    assert [command.dtype for command in seen] == (8 + 6 + 4) * [torch.float32]
    policy = load_policy(out / POLICY_FILE).network
    whole, store = config(*TINY, *WARP), inputs["library"][0] / STORE
    task = task_of(whole.robot, whole.env, whole.train.walking, store)
    assert Selector(task, 1).score(policy).value == facts["value"]
    own = settings() | {"controller": "policy", "case": to_dict(at_speed(0.2))}
    own["evaluation"] = to_dict(config(*TINY, "evaluation.duration=0.4").evaluation)
    (tmp_path / "evaluated").mkdir()
    found = evaluation.run(own, {"walking": [out]}, tmp_path / "evaluated", Job(tmp_path))
    assert found["blow_ups"] == 0
    assert (tmp_path / "evaluated" / "robots.csv").exists()
