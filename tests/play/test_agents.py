"""Controllers in the viewer: they obey a command that changes, and a push."""

from pathlib import Path

import numpy as np
import pytest

from slider.cli import main
from slider.config.compose import compose
from slider.play.motion import Simulation, simulate_model_based

CONF = Path(__file__).parents[2] / "conf"


@pytest.fixture
def motion() -> Simulation:
    config = compose(["experiment=test"], CONF)
    plant = config.env.plant
    test, control = config.evaluation, config.control["mpc_wbc_tuned"]
    disturbance = test.disturbance
    return simulate_model_based(config.robot, plant, control, None, test.start, 0, disturbance)


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


def play(*arguments: str) -> int:
    return main(["play", *arguments, "--conf", str(CONF), "--headless", "--seconds", "1"])


@pytest.mark.parametrize("name", ["mpc_wbc_literal", "mpc_wbc_observer"])
def test_a_controller_of_the_configuration_can_be_watched(name, capsys):
    assert play(name) == 0
    assert f"controller {name}: up after 1.00 s" in capsys.readouterr().out


def test_an_unknown_agent_is_answered_by_the_known_ones(capsys):
    assert play("mpc_wbc_tunde") == 1
    files = sorted(path.stem for path in (CONF / "control").glob("*.yaml"))
    known = ", ".join(["policy", *(name for name in files if name != "base"), "zero", "random"])
    expected = f"agent: expected one of {known}, found mpc_wbc_tunde"
    assert expected in capsys.readouterr().err
