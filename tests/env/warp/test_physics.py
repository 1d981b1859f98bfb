"""MuJoCo Warp on its CPU device against MuJoCo, with the same graphs as on CUDA."""

# pyright: reportAttributeAccessIssue=false

from dataclasses import replace

import mujoco
import numpy as np
import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode

from slider.core.errors import UserError
from slider.env.disturbance.machines import COLUMNS, Machines
from slider.robot.names import NUM_JOINTS
from tests.env.synthetic import config, make_physics, robot_config

pytest.importorskip("mujoco_warp", reason="needs the extra gpu")

from slider.env.warp.machines import WarpMachines
from slider.env.warp.physics import WarpPhysics
from slider.env.warp.simulation import use_kernel_cache, wp

N = 6
SINK = 5e-4  # [m]; a foot that just touches is a contact in one precision and not in the other
VARIED = config(
    "experiment=test",
    "evaluation.disturbance.mass={lower: 0.8, upper: 1.2}",
    "evaluation.disturbance.motor_gain={lower: 0.9, upper: 1.1}",
    "evaluation.disturbance.friction={lower: 0.4, upper: 1.0}",
    "evaluation.disturbance.centre_of_mass=0.03",
).evaluation.disturbance


@pytest.fixture(scope="module")
def made() -> WarpPhysics:
    """Robots that may vary; compiled once, unless Warp's cache has it."""
    return WarpPhysics(robot_config(), config("experiment=test").env.physics, N, varied=True)


@pytest.fixture
def physics(made: WarpPhysics) -> WarpPhysics:
    """All nominal and at rest, none retired."""
    place(made, *stance())
    draw(made, torch.full((N, COLUMNS), 0.5), nominal=True)
    made.disturber = None
    made.simulation.forgive(everyone())
    return made


def tensor(values: np.ndarray) -> torch.Tensor:
    return torch.as_tensor(values, dtype=torch.float32)


def everyone() -> torch.Tensor:
    return torch.ones(N, dtype=torch.bool)


def place(physics: WarpPhysics, qpos: np.ndarray, qvel: np.ndarray) -> None:
    physics.reset(everyone(), tensor(qpos), tensor(qvel))


def draw(physics: WarpPhysics, uniform: torch.Tensor, nominal: bool = False) -> WarpMachines:
    settings = config("experiment=test").evaluation.disturbance if nominal else VARIED
    machines = physics.machines(settings)
    machines.draw(everyone(), uniform)
    return machines


def stance(count: int = N) -> tuple[np.ndarray, np.ndarray]:
    """Robots on both feet that begin to move."""
    qpos = np.tile(make_physics(1).nominal, (count, 1))
    qpos[:, 2] -= SINK
    qvel = np.zeros((count, 18))
    qvel[:, 0] = np.linspace(0.0, 0.01, count)
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


def test_fifty_steps_from_stance_equal_mujocos(physics):
    """In positions, sensors and everything that controllers and rewards read of them."""
    other = make_physics(N)
    other.reset(np.arange(N), *stance())
    place(physics, *stance())
    targets = np.zeros((N, NUM_JOINTS))
    for _ in range(50 // 4 + 1):
        physics.step(tensor(targets))
        other.step(targets)
    np.testing.assert_allclose(physics.qpos, other.qpos, rtol=0, atol=1e-6)
    np.testing.assert_allclose(physics.qvel, other.qvel, rtol=0, atol=1e-4)
    found, expected = physics.read(), other.read()
    for name in vars(expected):
        if name != "ground":
            values = getattr(found, name)
            assert isinstance(values, torch.Tensor)
            assert values.dtype in (torch.float32, torch.bool)
            np.testing.assert_allclose(values, getattr(expected, name), rtol=0, atol=1e-3)
    assert expected.foot_forces.min() > 5.0, "no contact: the comparison would prove little"
    physics.check()


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


def test_a_reset_of_some_leaves_the_others_untouched(physics):
    """Bit by bit, with the models of those that are reset drawn anew."""
    machines = physics.machines(VARIED)
    generator = torch.Generator().manual_seed(1)
    machines.draw(everyone(), torch.rand((N, COLUMNS), generator=generator))
    some = torch.tensor([False, True, False, False, True, False])
    targets = torch.full((N, NUM_JOINTS), 0.02)
    runs = []
    for reset in (False, True):
        place(physics, *stance())
        physics.step(targets)
        if reset:
            machines.draw(some, torch.rand((N, COLUMNS), generator=generator))
            physics.reset(some, 1.1 * physics.qpos, 1.0 + physics.qvel)
            assert (physics.read().foot_forces[some] == 0.0).all()
            assert (physics.read().foot_forces[~some] > 5.0).all()
        physics.step(targets)
        runs.append((physics.qpos.clone(), physics.qvel.clone(), physics.read().foot_forces))
    for before, after in zip(*runs, strict=True):
        assert torch.equal(before[~some], after[~some])
        assert (before[some] != after[some]).any(dim=-1).all()


def test_robots_differ_and_each_equals_its_own_model_in_mujoco(physics):
    uniform = np.random.default_rng(5).uniform(size=(N, COLUMNS))
    machines = draw(physics, tensor(uniform))
    models = Machines(physics.model, VARIED, N)
    models.draw(np.arange(N), uniform)
    np.testing.assert_allclose(machines.masses, models.masses(np.arange(N)), rtol=1e-6)
    for name in ("body_subtreemass", "body_invweight0", "dof_invweight0"):
        expected = np.array([getattr(model, name) for model in models.models])
        np.testing.assert_allclose(physics.simulation.field(name), expected, rtol=1e-4, atol=1e-7)
    qpos, qvel = stance()
    place(physics, qpos, qvel)
    targets = np.tile([0.0, 0.05, 0.1, 0.02, -0.1, 0.0], (N, 2))
    for _ in range(3):
        physics.step(tensor(targets))
    ends = []
    other = make_physics(N)
    for i, model in enumerate(models.models):
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = qpos[i], qvel[i]
        data.ctrl[:] = other._to_motors(targets[i])
        for step in range(12):
            if step % 4 == 0:
                data.qacc_warmstart[:] = 0.0
            mujoco.mj_step(model, data)
        ends.append(data.qpos.copy())
    np.testing.assert_allclose(physics.qpos, ends, rtol=0, atol=1e-6)
    assert np.abs(np.diff(ends, axis=0)).max(axis=1).min() > 1e-3, "the robots do not differ"


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


def test_retired_robots_stay_until_they_are_placed(physics):
    targets = torch.full((N, NUM_JOINTS), 0.03)
    physics.step(targets)
    idle = torch.tensor([True, False] * 3)
    physics.retire(idle)
    before, forces = physics.qpos.clone(), physics.read().foot_forces
    physics.step(targets)
    assert torch.equal(physics.qpos[idle], before[idle])
    assert torch.equal(physics.read().foot_forces[idle], forces[idle])
    assert (physics.qpos[~idle] != before[~idle]).any(dim=1).all()
    place(physics, *stance())
    physics.step(-targets)
    assert (physics.qpos[idle] != before[idle]).any(dim=1).all()


def test_an_overflow_is_an_error_that_names_the_robots():
    small = WarpPhysics(robot_config(), config("experiment=test").env.physics, N, rows=12)
    qpos, qvel = stance()
    qpos[[0, 2, 3, 5], 2] += 1.0  # in the air they have no contacts
    place(small, qpos, qvel)
    small.step(torch.zeros((N, NUM_JOINTS)))
    with pytest.raises(UserError, match=f"found NEFC of 2 of {N} robots: 1, 4$"):
        small.check()
    small.check()  # told once


class Disturber:
    """A push of the first robot, drives that are a step late, and noise."""

    def __init__(self) -> None:
        self.last = torch.zeros((N, 4, 10))

    def begin(self, robots: torch.Tensor, qpos: torch.Tensor) -> torch.Tensor:
        return qpos

    def push(self, qvel: torch.Tensor) -> None:
        qvel[:, 0] += 0.5 * (torch.arange(N) == 0)

    def drive(self, control: torch.Tensor) -> torch.Tensor:
        self.last, late = control, self.last
        return late

    def sense(self, state):
        return replace(state, yaw=state.yaw + 1.0)

    def restart(self) -> None:
        self.last = torch.zeros((N, 4, 10))


def test_disturbances_reach_the_robots(physics):
    targets = torch.full((N, NUM_JOINTS), 0.05)
    physics.step(0.0 * targets)
    still = physics.qpos.clone()
    place(physics, *stance())
    physics.disturber = Disturber()
    physics.step(targets)
    assert torch.equal(physics.qpos[1:], still[1:]), "the drives were not late"
    assert physics.qpos[0, 0] - still[0, 0] > 0.5 * 0.5 * physics.period
    physics.step(targets)
    assert (physics.qpos[1:, 7:] - still[1:, 7:]).abs().max() > 1e-3
    state = physics.read()
    assert torch.equal(physics.measure(state).yaw, state.yaw + 1.0)


class NoRoundTrip(TorchDispatchMode):
    """Fails where torch would wait for the device or copy between devices."""

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        name = str(func)
        assert "_local_scalar_dense" not in name, name
        assert "nonzero" not in name, name
        assert "masked_select" not in name, name
        assert "_to_copy" not in name, name
        return func(*args, **(kwargs or {}))


def test_a_control_step_makes_no_round_trip_to_the_host(physics):
    machines = physics.machines(VARIED)
    uniform, some = torch.rand((N, COLUMNS)), torch.arange(N) % 2 == 0
    targets, (qpos, qvel) = torch.zeros((N, NUM_JOINTS)), map(tensor, stance())
    physics.retire(some)
    with NoRoundTrip():
        physics.step(targets)
        physics.measure(physics.read())
        machines.draw(some, uniform)
        physics.reset(some, qpos, qvel)
    with pytest.raises(AssertionError, match="_local_scalar_dense"), NoRoundTrip():
        float(targets.sum())


def test_an_unknown_device_is_one_line():
    with pytest.raises(UserError, match=r"device: expected one of cpu.*, found cuda:9$"):
        WarpPhysics(robot_config(), config("experiment=test").env.physics, 1, "cuda:9")


def test_the_kernels_can_be_kept_elsewhere(tmp_path, monkeypatch):
    monkeypatch.setattr(wp.config, "kernel_cache_dir", None)
    use_kernel_cache(tmp_path / "kernels")
    assert wp.config.kernel_cache_dir == str(tmp_path / "kernels")
    assert (tmp_path / "kernels").is_dir()
