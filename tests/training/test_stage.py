"""The stages train with what they are given: library, standing policy, both or neither."""

from unittest.mock import Mock

import numpy as np
import pytest

from slider.config.convert import to_dict
from slider.control import POLICY_FILE
from slider.control.policy import load_policy
from slider.core.job import Job, Section
from slider.training import trainer
from slider.training.trainer import run_walking
from tests.env.synthetic import config
from tests.library.gaits import straight
from tests.training.test_trainer import TINY, same

ALONE = (
    "env/phase=fixed",
    "env.action.offset=nominal",
    "train/walking/reward=unguided",
    "train.walking.reset.reference_fraction=0",
)
FINETUNING = (
    *TINY,
    "finetuning=robust",
    "finetuning.robots=8",
    "finetuning.steps_per_iteration=8",
    "finetuning.ppo.precision=float32",
    "finetuning.selection={robots: 1, duration: 0.2, warm_up: 0.1}",
)


def section(*overrides: str) -> Section:
    whole = config(*TINY, *overrides)
    robot = to_dict(whole.robot)
    robot.pop("provenance")
    return {"robot": robot, "env": to_dict(whole.env), "train": to_dict(whole.train.walking)}


def test_trains_with_neither_library_nor_standing_policy(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    run_walking(section(*ALONE, "train.walking.iterations=1"), {}, out, Job(tmp_path / "work"))
    policy = load_policy(out / POLICY_FILE)
    assert policy.reference is None
    pace = config(*ALONE).env.phase.step_time
    np.testing.assert_array_equal(
        policy.times.at(np.array([(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)])), pace
    )


def test_a_fine_tuning_goes_on_from_a_walking_policy(tmp_path):
    """Without an iteration of its own it hands the policy on; with one it learns."""
    folders = {name: tmp_path / name for name in ("walking", "same", "tuned")}
    for folder in folders.values():
        folder.mkdir()
    inputs = {"library": [straight()]}
    run_walking(section("train.walking.iterations=1"), inputs, folders["walking"], Job(tmp_path))
    inputs["start"] = [folders["walking"]]
    for name, iterations in {"same": 0, "tuned": 1}.items():
        whole = config(*FINETUNING, f"finetuning.iterations={iterations}")
        assert whole.finetuning.disturbance.push.impulse.upper > 0
        tuning = {**section(), "train": to_dict(whole.finetuning)}
        run_walking(tuning, inputs, folders[name], Job(tmp_path / f"work_{name}"))
    weights = {n: load_policy(f / POLICY_FILE).network.state_dict() for n, f in folders.items()}
    assert same(weights["walking"], weights["same"])
    assert not same(weights["walking"], weights["tuned"])


def test_a_training_runs_in_its_simulator(tmp_path, monkeypatch):
    monkeypatch.setattr(trainer, "simulator", lambda _: Mock(side_effect=KeyError))
    with pytest.raises(KeyError):
        run_walking(section(*ALONE), {}, tmp_path, Job(tmp_path))
