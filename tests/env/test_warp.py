"""MuJoCo Warp on its CPU device against MuJoCo, with the same graphs as on CUDA."""

from contextlib import suppress
from typing import Any

import numpy as np
import pytest
import torch

from slider.core.errors import UserError
from slider.env.disturbance import Disturbance, SeededRandom
from slider.env.physics import BatchedPhysics
from slider.env.randomization import COLUMNS, RandomizedRobots
from slider.robot.names import NUM_JOINTS
from tests.env.synthetic import config, disturbance, make_physics, robot_config

pytest.importorskip("mujoco_warp", reason="needs the extra gpu")

from slider.env import warp
from slider.env.warp import WarpPhysics

N = 6
EVERYONE = torch.arange(N)
SINK = 5e-4  # [m]; a foot that just touches is a contact in one precision and not in the other
DISTURBED = disturbance(
    "mass={lower: 0.8, upper: 1.2}",
    "motor_gain={lower: 0.9, upper: 1.1}",
    "friction={lower: 0.4, upper: 1.0}",
    "centre_of_mass=0.03",
    "delay={lower: 0.0, upper: 0.03}",
    "push.impulse={lower: 0.65, upper: 0.65}",
    "push={duration: 0.04, interval: 0.1}",
    "sensing.joint_position=0.005",
    "sensing.orientation=0.02",
)


class Numbers(SeededRandom):
    """Those of NumPy, as tensors."""

    def _draw(self, *arguments: Any) -> Any:
        return tensor(super()._draw(*arguments))


@pytest.fixture(scope="module")
def made() -> WarpPhysics:
    """Disturbed robots; compiled once, unless Warp's cache has it."""
    physics = config("experiment=test").env.physics
    return WarpPhysics(robot_config(), physics, N, disturbance=Disturbance(DISTURBED, (1, 2)))


@pytest.fixture
def physics(made: WarpPhysics, monkeypatch) -> WarpPhysics:
    """All nominal, at rest and undisturbed."""
    nominal = RandomizedRobots(made.model, disturbance(), N, made.set_fields, made.qpos)
    nominal.draw(EVERYONE, torch.full((N, COLUMNS + made.model.nu), 0.5))
    monkeypatch.setattr(made, "_disturber", None)
    return clean(made)


@pytest.fixture
def disturbed(made: WarpPhysics) -> WarpPhysics:
    """As after construction."""
    clean(made).restart_disturbances()
    return made


def clean(physics: WarpPhysics) -> WarpPhysics:
    """In stance, no overflow."""
    place(physics, *stance())
    with suppress(UserError):
        physics.check()
    return physics


def tensor(values: np.ndarray) -> torch.Tensor:
    return torch.as_tensor(values, dtype=torch.float32)


def place(physics: WarpPhysics, qpos: np.ndarray, qvel: np.ndarray) -> None:
    physics.reset(EVERYONE, tensor(qpos), tensor(qvel))


def stance() -> tuple[np.ndarray, np.ndarray]:
    """Robots on both feet that begin to move."""
    qpos, qvel = np.tile(make_physics(1).nominal, (N, 1)), np.zeros((N, 18))
    qpos[:, 2] -= SINK
    qvel[:, 0] = np.linspace(0.0, 0.01, N)
    return qpos, qvel


def walk(steps: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """States and targets of robots that lift, swing and land their feet; then some fall."""
    physics, rng = make_physics(N), np.random.default_rng(3)
    physics.reset(np.arange(N), *stance())
    states, sway = [], rng.uniform(0.5, 1.5, (N, 1))
    for step in range(steps):
        angle = 2 * np.pi * (step / 20 + np.array([0.0] * 6 + [0.5] * 6))
        targets = sway * np.tile([0.0, 0.03, -0.15, -0.05, 0.1, 0.0], 2) * np.sin(angle)
        states.append((physics.qpos.copy(), physics.qvel.copy(), targets))
        physics.step(targets)
    return states


def test_walking_states_with_changing_contacts_step_as_in_mujoco(physics):
    other, forces, errors = make_physics(N), [], []
    for qpos, qvel, targets in walk(60)[::4]:
        other.reset(np.arange(N), qpos, qvel)
        place(physics, qpos, qvel)
        other.step(targets)
        physics.step(tensor(targets))
        forces.append(other.read().foot_forces > 5.0)
        errors.append(np.abs(physics.qvel.numpy() - other.qvel).max(axis=1))
    seen = np.concatenate(forces)
    assert {tuple(row) for row in seen} == {(a, b) for a in (False, True) for b in (False, True)}
    # A foot that lands within a step may do so a simulation step later: its velocity differs.
    assert np.median(errors) < 1e-5
    assert np.mean(np.array(errors) < 1e-3) > 0.9
    physics.check()


def test_a_reset_of_some_leaves_the_others_untouched(disturbed):
    """Bit by bit, with robots, delays and pushes of those that are reset drawn anew."""
    some = torch.tensor([False, True, False, False, True, False])
    targets = torch.full((N, NUM_JOINTS), 0.02)
    runs = []
    for reset in (False, True):
        disturbed.restart_disturbances()
        place(disturbed, *stance())
        disturbed.step(targets)
        before = disturbed.field("body_mass").sum(dim=1)
        if reset:
            qpos, qvel = 1.1 * disturbed.qpos[some], 1.0 + disturbed.qvel[some]
            disturbed.reset(some.nonzero().flatten(), qpos, qvel)
            assert torch.equal(disturbed.field("body_mass").sum(dim=1) != before, some)
            assert (disturbed.read().foot_forces[some] == 0.0).all()
            assert (disturbed.read().foot_forces[~some] > 5.0).all()
        for _ in range(5):  # a push is in them
            disturbed.step(targets)
        runs.append((disturbed.qpos.clone(), disturbed.qvel.clone(), disturbed.read().foot_forces))
    for before, after in zip(*runs, strict=True):
        assert torch.equal(before[~some], after[~some])
        assert (before[some] != after[some]).any(dim=-1).all()


def test_disturbed_robots_are_those_of_mujoco_by_the_same_numbers(disturbed, monkeypatch):
    """Masses, friction, motors, delays, pushes and noise, over 52 simulation steps."""
    settings, seeds = config("experiment=test").env.physics, (1, 2)
    other = BatchedPhysics(robot_config(), settings, N, disturbance=Disturbance(DISTURBED, seeds))
    monkeypatch.setattr(disturbed._disturber, "_draws", Numbers(seeds, N))
    disturbed.restart_disturbances()
    other.reset(np.arange(N), *stance())
    place(disturbed, *stance())
    for name in ("body_subtreemass", "body_invweight0", "dof_invweight0"):
        expected = np.array([getattr(model, name) for model in other.models])
        np.testing.assert_allclose(disturbed.field(name), expected, rtol=1e-4, atol=1e-7)
    np.testing.assert_allclose(disturbed.field("body_mass").sum(dim=1), other.masses, rtol=1e-6)
    for step in range(13):
        targets = 0.02 * np.sin(0.3 * step + np.arange(N * NUM_JOINTS).reshape(N, NUM_JOINTS))
        other.step(targets)
        disturbed.step(tensor(targets))
    np.testing.assert_allclose(disturbed.qpos, other.qpos, rtol=0, atol=1e-6)
    found, expected = (p.measure(p.read()) for p in (disturbed, other))
    for name in ("joint_positions", "quaternion", "gravity"):
        values = getattr(expected, name)
        np.testing.assert_allclose(getattr(found, name), values, rtol=0, atol=1e-5)
        assert np.abs(values - getattr(other.read(), name)).max() > 1e-3
    assert len(set(disturbed._disturber._delay.steps.tolist())) > 2, "delays do not differ"
    assert np.abs(np.diff(other.qpos, axis=0)).max(axis=1).min() > 1e-3, "the robots do not differ"


def test_a_blow_up_is_found_and_stays_alone(physics):
    targets = torch.zeros((N, NUM_JOINTS))
    physics.step(targets)
    clean = physics.qpos.clone(), physics.qvel.clone()
    place(physics, *stance())
    physics.qpos[2, 8], physics.qvel[3, 6:] = torch.nan, 1e9
    spoiled = targets.clone()
    spoiled[4, 3] = torch.nan
    physics.step(spoiled)
    assert physics.read().diverged.tolist() == [False, False, True, True, True, False]
    others = torch.tensor([0, 1, 5])
    assert torch.equal(physics.qpos[others], clean[0][others])
    assert torch.equal(physics.qvel[others], clean[1][others])
    assert (physics.qvel[2:5] == 0.0).all()
    for _ in range(3):
        physics.step(targets)
    assert not physics.read().diverged.any()
    physics.check()


def test_an_overflow_is_an_error_that_names_the_robots(monkeypatch):
    monkeypatch.setattr(warp, "ROWS", 12)
    small = WarpPhysics(robot_config(), config("experiment=test").env.physics, N)
    qpos, qvel = stance()
    qpos[[0, 2, 3, 5], 2] += 1.0  # in the air they have no contacts
    place(small, qpos, qvel)
    small.step(torch.zeros((N, NUM_JOINTS)))
    with pytest.raises(UserError, match=f"found NEFC of 2 of {N} robots: 1, 4$"):
        small.check()
    small.check()  # told once
