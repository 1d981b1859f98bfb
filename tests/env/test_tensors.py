"""The environment on torch tensors: the numbers of NumPy, and nobody waits for the device."""

from typing import Any

import numpy as np
import pytest
import torch

from slider.core.arrays import Array, asarray, beside, constant
from slider.env import vec_env
from slider.env.physics import BatchedPhysics
from slider.env.state import RobotState
from slider.env.task import Task
from slider.env.tensors import DeviceRandom, from_torch
from slider.env.underlying import build_physics
from slider.env.vec_env import WalkingEnv
from tests.env.synthetic import config, gait_table, make_guide
from tests.env.test_libraries import LIKE, NoWaiting

COUNT = 12
SETTINGS = (
    "experiment=test",
    f"train.walking.robots={COUNT}",
    "train/walking/disturbance=robust",
    "train/walking/reward=clf",
    "train.walking.episode_length=0.4",
    "train.walking.reset.reference_fraction=0.5",
    "train.walking.commands.period=0.4",
    "train.walking.commands.standing_fraction=0.3",
    "train.walking.commands.curriculum={start: 0.4, growth: 0.1, success: 0.2}",
    "env.action.offset=gait",
    "env.phase.halt.below=0.2",
    "env.phase.halt.above=0.4",
)


class TensorPhysics:
    """MuJoCo's own physics, below an environment of tensors."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        self._batched = build_physics(*arguments, **settings)

    @property
    def qpos(self) -> torch.Tensor:
        return torch.from_numpy(self._batched.qpos)

    def step(self, inputs: torch.Tensor) -> None:
        self._batched.step(inputs.numpy())

    def reset(self, robots: torch.Tensor, qpos: torch.Tensor, qvel: torch.Tensor) -> None:
        index = np.flatnonzero(robots.numpy())
        if len(index):
            self._batched.reset(index, qpos.numpy()[index], qvel.numpy()[index])

    def read(self) -> RobotState:
        return beside(self._batched.read(), LIKE)

    def measure(self, state: RobotState) -> RobotState:
        return beside(self._batched.measure(self._batched.read()), LIKE)


class SameNumbers:
    """Random numbers of a robot that do not depend on which other robots ask for some."""

    def __init__(self, like: Array) -> None:
        self._like = like
        self._rng = np.random.default_rng(0)
        self.asking: list[Array] = []

    def begin(self, *key: int) -> None:
        """Let the numbers follow from a key."""
        self._rng = np.random.default_rng(key)
        self.asking = [np.arange(COUNT)]

    def _rows(self, values: np.ndarray, count: int) -> Array:
        (robots,) = [index for index in self.asking if len(index) == count][:1]
        return asarray(values[robots], self._like)

    def uniform(self, low: Any = 0.0, high: Any = 1.0, size: Any = ()) -> Array:
        count, *columns = np.atleast_1d(size)
        return low + (high - low) * self._rows(self._rng.uniform(size=(COUNT, *columns)), count)

    def standard_normal(self, size: Any) -> Array:
        count, *columns = size
        return self._rows(self._rng.standard_normal((COUNT, *columns)), count)


class Followed(WalkingEnv):
    """Says which robots draw numbers, since rows of NumPy do not say it."""

    steps = 0
    _rng: SameNumbers

    def _ask(self, index: Array) -> None:
        if isinstance(index, np.ndarray):
            self._rng.asking.append(index)

    def _reset(self, index: Array) -> RobotState:
        self._rng.begin(self.steps, 0)
        self._ask(index)
        self._index = index
        return super()._reset(index)

    def _choose_reference_starts(self, count: int) -> Array:
        on_gait = super()._choose_reference_starts(count)
        if isinstance(on_gait, np.ndarray):
            self._ask(self._index[on_gait])
        return on_gait

    def _change_commands(self) -> None:
        self._rng.begin(self.steps, 1)
        real = type(self._commands).changing

        def changing(*arguments: Any) -> Array:
            index = real(self._commands, *arguments)
            self._ask(index)
            return index

        self._commands.changing = changing  # type: ignore[method-assign]
        super()._change_commands()
        self.steps += 1


def sunk(monkeypatch: pytest.MonkeyPatch) -> None:
    """A foot that just touches is a contact or none, by the last bit: let all feet sink in."""
    real = BatchedPhysics.reset

    def reset(physics: Any, index: np.ndarray, qpos: np.ndarray, qvel: np.ndarray) -> None:
        real(physics, index, qpos - 5e-4 * (np.arange(19) == 2), qvel)

    monkeypatch.setattr(BatchedPhysics, "reset", reset)


def make(simulate: Any, kind: type[WalkingEnv] = WalkingEnv) -> Any:
    whole, table = config(*SETTINGS), gait_table()
    walking = whole.train.walking
    task = Task(whole.robot, whole.env, walking, table.times, make_guide(), table.joints)
    return kind(task, simulate=simulate)


def close(found: Any, expected: Any, tolerance: float = 1e-9) -> None:
    np.testing.assert_allclose(np.asarray(found), expected, rtol=tolerance, atol=tolerance)


def test_a_hundred_steps_are_those_of_numpy(monkeypatch):
    """Observations, rewards and what is logged are float32; what they follow from is not."""
    monkeypatch.setattr(vec_env, "generator", lambda seed, like: SameNumbers(like))
    sunk(monkeypatch)
    on_numpy, on_torch = (make(kind, Followed) for kind in (build_physics, TensorPhysics))
    draw = torch.Generator().manual_seed(0)
    seen = dict.fromkeys(("fell", "late", "changed", "halted", "mirrored", "started"), 0)
    for _ in range(100):
        actions = 1.5 * torch.randn(COUNT, 12, generator=draw, dtype=torch.float64)
        command = on_numpy.agent.command[:, :3].copy()
        results = [env.step(actions) for env in (on_numpy, on_torch)]
        (one, reward, done, extras), (other, *found, log) = results
        close(other["policy"], one["policy"], 1e-6)
        close(found[0], reward, 1e-6)
        assert torch.equal(found[1], done)
        assert torch.equal(log["time_outs"], extras["time_outs"])
        assert log["log"].keys() == extras["log"].keys()
        for name, value in extras["log"].items():
            close(log["log"][name], value, 1e-6)
        for name in ("command", "action", "filtered_velocity", "expected_velocity"):
            close(getattr(on_torch.agent, name), getattr(on_numpy.agent, name))
        clock = on_numpy.agent.clock
        close(on_torch.agent.clock.phase, clock.phase)
        close(on_torch.physics.qpos, on_numpy.physics.qpos)
        assert torch.equal(on_torch.episode_length_buf, on_numpy.episode_length_buf)
        late, ended = extras["time_outs"].numpy() > 0, done.numpy() > 0
        changed = (on_numpy.agent.command[:, :3] != command).any(axis=1) & ~ended
        started = ended & (on_numpy.agent.filtered_velocity != 0).any(axis=1)
        flags = (ended & ~late, late, changed, clock.halted, ~clock.left_stance, started)
        for name, flag in zip(seen, flags, strict=True):
            seen[name] += flag.sum()
    assert all(count > 5 for count in seen.values()), seen
    share = on_numpy.curriculum.share.item()
    assert share > 0.4
    assert on_torch.curriculum.share.item() == share


def test_a_step_waits_for_nothing():
    """Starts, ends and changes of commands included; after the first step nothing is copied."""
    env = make(TensorPhysics)
    env.step(torch.zeros(COUNT, 12))
    ended = torch.zeros(COUNT, dtype=torch.long)
    with NoWaiting():
        for _ in range(40):
            observations, reward, done, extras = env.step(torch.ones(COUNT, 12))
            ended += done
            assert observations.batch_size == (COUNT,)
    assert ended.min() > 0
    assert observations["policy"].dtype == reward.dtype == extras["time_outs"].dtype
    assert reward.dtype == torch.float32
    assert all(isinstance(value, torch.Tensor) for value in extras["log"].values())


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_numbers_of_a_device_have_its_precision_and_follow_from_the_seed(dtype):
    like: Any = torch.zeros(0, dtype=dtype)
    one, same, other = (DeviceRandom(seed, like) for seed in (3, 3, 4))
    low, high = torch.tensor([-1.0, 2.0], dtype=dtype), torch.tensor([0.0, 6.0], dtype=dtype)
    found = one.uniform(low, high, (4000, 2))
    assert found.dtype == dtype
    assert torch.equal(found, same.uniform(low, high, (4000, 2)))
    assert not torch.equal(found, other.uniform(low, high, (4000, 2)))
    assert (found >= low).all()
    assert (found < high).all()
    close(found.mean(dim=0), [-0.5, 4.0], 0.05)
    normal = one.standard_normal((4000, 3))
    assert normal.dtype == dtype
    close(normal.std(dim=0), np.ones(3), 0.05)
    assert one.uniform(size=5).shape == (5,)


def test_actions_take_the_precision_of_the_environment():
    actions = torch.full((2, 12), 0.1)
    assert from_torch(actions, np.zeros(0)).dtype == np.float64
    assert from_torch(actions, LIKE).dtype == torch.float64
    assert from_torch(actions > 0, LIKE).dtype == torch.bool


def test_a_constant_goes_to_a_device_once_and_is_forgotten_with_its_source():
    values = np.arange(12.0)
    first = constant(values, LIKE)
    assert constant(values, LIKE) is first
    assert constant(list(range(3)), LIKE) is constant(list(range(3)), LIKE)
    assert constant(values, torch.zeros(0)).dtype == torch.float32  # type: ignore[arg-type]
    from slider.core import arrays

    before = len(arrays._CONSTANTS)
    del values
    assert len(arrays._CONSTANTS) == before - 2
    np.testing.assert_array_equal(constant(np.arange(3.0) + 7, LIKE), [7, 8, 9])
