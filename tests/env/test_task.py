"""A task holds the gaits that its configuration asks for."""

import dataclasses

import numpy as np
import pytest

from slider.env.vec_env import Task, task_of
from tests.env.synthetic import config
from tests.library.gaits import write_store


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return write_store(tmp_path_factory.mktemp("library"), [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0)])


def make(library, *overrides: str, guided: bool = True) -> Task:
    whole = config("experiment=test", *overrides)
    return task_of(whole.robot, whole.env, whole.train.walking, library, guided)


def test_actions_about_the_gait_get_the_gaits(library):
    assert make(library, "env.action.offset=nominal").reference is None
    reference = make(library, "env.action.offset=gait").reference
    assert reference is not None
    assert reference.positions.shape == (3, 1, 1, 42, 12)


def test_only_a_guided_training_gets_a_guide(library):
    whole, unguided = make(library), make(library, guided=False)
    assert whole.guide is not None
    assert unguided.guide is None
    assert unguided.reference is not None, "its actions are about the gait all the same"
    assert dataclasses.replace(whole, guide=None, times=None, reference=None) == (
        dataclasses.replace(unguided, times=None, reference=None)
    )


def test_the_clock_runs_at_its_own_pace_or_at_that_of_the_gaits(library):
    commands = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    clocks = {
        "env/phase=clock": [0.42, 0.37],  # as the gaits were written
        "env.phase.step_time=0.3": [0.3, 0.3],
    }
    for override, expected in clocks.items():
        times = make(library, override).times
        assert times is not None
        np.testing.assert_allclose(times.at(commands), expected)
    assert make(library, "env/phase=none").times is None
    assert make(None, "env/phase=clock").times is None
