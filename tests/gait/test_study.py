"""Gaits on several meshes, whose differences are known, and from random starts."""

import json
from dataclasses import replace

import numpy as np
import pytest

from slider.config.gait import StartSpread
from slider.config.types import Interval
from slider.core.job import Job
from slider.gait import REPORT
from slider.gait.guess import random_start
from slider.gait.solve import GIVEN
from slider.gait.stage import gait_arrays
from slider.gait.study import MeshGait, run
from tests.gait.gaits import problem, section, solved
from tests.gait.test_solve import cost_of

DURATION = (0.25, 0.42)
SPREAD = StartSpread(0.5, Interval(0.3, 1.2), Interval(0.5, 1.5))


def gait(nodes: int, offset: float = 0.0, roll: float = 0.0) -> MeshGait:
    """All joints and torques are the phase; a bump of the roll at mid-step and at its end."""
    phase = np.linspace(0.0, 1.0, nodes)
    joints = np.tile(phase[None, :, None], (2, 1, 10))
    bump = roll * np.isin(phase, (0.5, 1.0)) * (1.0 + (phase == 0.5))
    return MeshGait(joints + offset, joints.copy(), np.tile(bump, (2, 1)), 0.4)


def test_the_torque_cost_is_the_optimisation_s_own(tmp_path):
    """At a solution for another cost."""
    for name, array in gait_arrays(problem(), solved(0.4, 0.0), "exact").items():
        np.save(tmp_path / f"{name}.npy", array)
    expected = cost_of("torque", solved(0.4, 0.0).variables)
    assert MeshGait.load(tmp_path).torque_cost == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("meshes", [(5, 9), (9, 5), (7, 11), (5, 5)])
def test_meshes_are_compared_at_common_phases(meshes):
    found = gait(meshes[0], 0.03, 0.01).difference(gait(meshes[1]))
    assert found["joints_difference"] == pytest.approx(0.03)
    assert found["roll_difference"] == pytest.approx(0.02)
    assert found["roll_end_difference"] == pytest.approx(0.01)


def start(*seed: int, spread: StartSpread = SPREAD, vx: float = 1.2) -> np.ndarray:
    return random_start(problem(), vx, DURATION, spread, np.random.default_rng(seed))


def test_starts_are_within_the_bounds_of_the_variables():
    lower, upper = problem().variable_bounds(DURATION)
    for index in range(20):
        found = start(1, index, spread=replace(SPREAD, joints=5.0))
        assert ((lower <= found) & (found <= upper)).all()


def test_starts_fill_their_spread():
    """Of the ankle, which no bound of a variable touches, the second step's noise by itself."""
    layout = problem().layout
    walks = np.array([start(1, index, vx=0.0) for index in range(200)])
    ankles = [walks[:, layout.joint_slice(step)].reshape(200, 10, -1)[:, 4] for step in range(2)]
    noise = (ankles[0] - ankles[1]) / 2  # the walk in both steps is the same
    assert 0.45 < np.abs(noise).max() <= 0.5
    times = walks[:, layout.time_index(0)]
    assert DURATION[0] <= times.min() < 0.26
    assert 0.41 < times.max() <= DURATION[1]
    np.testing.assert_array_equal(times, walks[:, layout.time_index(1)])


def test_the_stage_solves_from_the_random_start_alone(tmp_path):
    spread = {"joints": 0.05, "crouch": {"lower": 0.8, "upper": 1.0}}
    given = {"seed": 1, "index": 3, "spread": spread | {"stride": {"lower": 0.9, "upper": 1.1}}}
    job = Job(tmp_path)
    summary = run(section(0.4, 0.0) | {"start": given}, {}, tmp_path, job)
    report = json.loads((tmp_path / REPORT).read_text())
    assert [attempt["name"] for attempt in report["attempts"]] == [GIVEN]
    assert summary["converged"]
    assert summary["cost"] == pytest.approx(solved(0.4, 0.0).cost, rel=1e-4)
    assert job.metadata["solve_cpu"] > 0
    assert [path.name for path in tmp_path.iterdir()] == [REPORT]
