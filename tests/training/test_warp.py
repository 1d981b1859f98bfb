"""A training with MuJoCo Warp: the same networks, checks and files."""

from pathlib import Path

import pytest
import torch

from slider.config.convert import to_dict
from slider.control import POLICY_FILE
from slider.control.policy import load_policy
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.vec_env import task_of
from slider.evaluation import stage as evaluation
from slider.library.reader import STORE
from slider.training.results import CURVE
from slider.training.selection import Selector
from slider.training.stage import run_walking
from tests.env.synthetic import config
from tests.library.gaits import write_store
from tests.training.test_stage import section
from tests.training.test_trainer import TINY

pytest.importorskip("mujoco_warp", reason="no extra gpu")

from slider.env.vec_env import WalkingEnv

WARP = (
    "train.walking.simulator=mujoco_warp",
    "train.walking.steps_per_iteration=4",
    "train.walking.seed=2",  # no episode ends in two iterations: equal columns
    "train/walking/disturbance=robust",
)


def settings(iterations: int) -> Section:
    return section(*WARP, f"train.walking.iterations={iterations}")


def train(work: Path, inputs: Inputs, iterations: int) -> tuple[Path, Job, Summary]:
    out, job = work / f"out_{iterations}", Job(work)
    out.mkdir()
    return out, job, run_walking(settings(iterations), inputs, out, job)


def test_a_policy_of_warp_is_resumed_and_evaluated_as_any_other(tmp_path, monkeypatch):
    """Robots that vary and are pushed; all is computed with tensors."""
    seen, real = [], WalkingEnv.step

    def step(env: WalkingEnv, actions: torch.Tensor) -> tuple:
        seen.append(env.agent.command)
        return real(env, actions)

    monkeypatch.setattr(WalkingEnv, "step", step)
    inputs = {"library": [write_store(tmp_path / "library", [(0.0, 0.0), (0.5, 0.0)]).parent]}
    first, job, _ = train(tmp_path, inputs, 1)
    assert "resumed" not in job.volatile
    out, job, facts = train(tmp_path, inputs, 2)
    assert job.volatile["resumed"] is True
    assert job.volatile["blow_ups"] == 0
    before, after = ((path / CURVE).read_text().splitlines() for path in (first, out))
    assert after[: len(before)] == before
    assert [row.split(",")[0] for row in after[1:]] == ["0", "1"]
    assert [command.dtype for command in seen] == 8 * [torch.float32]
    policy = load_policy(out / POLICY_FILE).network
    whole, store = config(*TINY, *WARP, "train.walking.iterations=2"), inputs["library"][0] / STORE
    task = task_of(whole.robot, whole.env, whole.train.walking, store)
    assert Selector(task, 1).score(policy).value == facts["value"]
    own = settings(2) | {"controller": "policy", "speed": 0.2}
    own["evaluation"] = to_dict(config(*TINY, "evaluation.duration=0.4").evaluation)
    (tmp_path / "evaluated").mkdir()
    found = evaluation.run(own, {"walking": [out]}, tmp_path / "evaluated", Job(tmp_path))
    assert found["blow_ups"] == 0
    assert (tmp_path / "evaluated" / "robots.csv").exists()
