"""The score that picks a checkpoint."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from slider.config.train import SelectionConfig
from slider.env.rollout import Recording
from slider.env.vec_env import Task
from slider.training import selection
from slider.training.selection import Selector
from tests.env.synthetic import config, gait_table, make_recording

SETTINGS = SelectionConfig(
    interval=1, speeds=[0.2, 2.0], robots=2, seed=1900, duration=1.0, warm_up=0.2, fall_weight=10.0
)


def make_selector(settings: SelectionConfig = SETTINGS) -> Selector:
    whole = config("experiment=test", "train/walking/disturbance=none")
    train, table = replace(whole.train.walking, selection=settings), gait_table()
    task = Task(whole.robot, whole.env, train, table.times, None, table.joints)
    return Selector(task, threads=1)


def nothing(observations: torch.Tensor) -> torch.Tensor:
    return torch.zeros(len(observations), 12)


def recorded(speeds: list[float], alive: list[bool]) -> Recording:
    """Constant speeds after a bad start, both feet down for three quarters of the time."""
    velocity = np.zeros((50, 4, 2))
    velocity[:, :, 0] = speeds
    velocity[:10] = 99.0
    forces = np.full((50, 4, 2), 100.0)
    forces[10:20] = 0.0
    command = np.tile([[v, 0.0, 0.0] for v in (0.2, 0.2, 2.0, 2.0)], (50, 1, 1))
    up = np.tile(alive, (50, 1))
    return make_recording(command, alive=up, velocity=velocity, foot_forces=forces)


def test_score_by_hand(monkeypatch):
    recording = recorded([0.26, 0.2, 1.7, 5.0], [True, True, True, False])
    monkeypatch.setattr(selection, "roll_out", lambda *_: recording)
    score = make_selector().score(nothing)
    relative = np.mean([0.0036 / (0.01 + 0.0004), 0.0, 0.09 / (0.01 + 0.04)])
    survivor = relative * 5.0 / (relative + 5.0)
    assert score.value == pytest.approx(10.0 / 4 + survivor * 3 / 4)
    assert score.success == 0.75
    assert score.tracked == 0.5, "the third walks 1.7 of 2 m/s"
    assert score.speed_error == pytest.approx(0.12)
    assert score.flight == pytest.approx(0.25)


def test_the_same_network_has_the_same_score():
    selector = make_selector(replace(SETTINGS, speeds=[0.0], duration=0.5, robots=4))
    first, second = selector.score(nothing), selector.score(nothing)
    assert first == second
    assert first.success == 1.0, "no robot falls within half a second"
    moved = replace(SETTINGS, speeds=[0.0], duration=0.5, robots=4, seed=1901)
    other = make_selector(moved)
    assert other.score(nothing).value != first.value
