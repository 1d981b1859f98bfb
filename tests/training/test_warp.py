"""A training with MuJoCo Warp: the same networks, checks and files."""

from functools import partial

import pytest

from slider.control import POLICY_FILE
from slider.control.policy_file import load_policy

pytest.importorskip("mujoco_warp", reason="no extra gpu")
from slider.training.trainer import Trainer
from slider.training.warp import build_physics
from tests.training.test_trainer import job, task


def test_a_policy_of_warp_is_judged_and_exported_as_any_other(tmp_path):
    trainer = Trainer(task(iterations=2), job(tmp_path), partial(build_physics, "cpu"))
    trainer.run()
    facts = trainer.export(tmp_path)
    assert trainer.env.total_diverged == 0
    assert trainer.env.agent.command.any()
    assert (
        trainer.selector.score(load_policy(tmp_path / POLICY_FILE).network).value == facts["value"]
    )
