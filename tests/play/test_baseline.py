"""The baseline in the viewer: it obeys a command that changes, and a push."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from slider.cli import main
from slider.commands.play import BASELINES
from slider.config.compose import compose
from slider.config.control import ControlConfig
from slider.config.env import PlantConfig
from slider.play.baseline import simulate_baseline
from slider.play.motion import Simulation

CONF = Path(__file__).parents[2] / "conf"


@pytest.fixture
def motion() -> Simulation:
    config = compose(["experiment=test"], CONF)
    plant = PlantConfig(config.env.control_period, config.env.physics, config.env.termination)
    test, control = config.evaluation, config.control.tuned
    return simulate_baseline(config.robot, plant, control, test.start, 0, test.disturbance)


def mean_velocity(motion: Simulation, command, seconds: float) -> np.ndarray:
    frames = [motion.step(np.array(command)) for _ in range(round(seconds / motion.period))]
    assert not frames[-1].failed
    return np.mean([frame.velocity for frame in frames[len(frames) // 2 :]], axis=0)


def test_obeys_a_command_that_changes(motion):
    motion.start(np.array([0.2, 0.0, 0.0]))
    assert mean_velocity(motion, [0.2, 0.0, 0.0], 3.0)[0] == pytest.approx(0.2, abs=0.08)
    assert mean_velocity(motion, [0.6, 0.0, 0.0], 4.0)[0] == pytest.approx(0.6, abs=0.08)


def test_a_push_moves_the_base(motion):
    motion.start(np.zeros(3))
    before = motion.step(np.zeros(3)).velocity
    motion.push(np.array([0.0, 0.4]))
    assert motion.step(np.zeros(3)).velocity[1] - before[1] > 0.2


def test_every_setting_of_the_baseline_can_be_watched(capsys):
    assert {f"mpc_wbc_{field.name}" for field in fields(ControlConfig)} == set(BASELINES)
    arguments = ["--conf", str(CONF), "--headless", "--seconds", "2"]
    assert main(["play", "mpc_wbc_literal", *arguments]) == 0
    assert "baseline mpc_wbc_literal: up after 2.00 s" in capsys.readouterr().out
