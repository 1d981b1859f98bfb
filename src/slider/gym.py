"""The training environment with Gymnasium's interface (extra ``gymnasium``).

``gymnasium.make("slider.gym:slider/Walking-v0")`` is one robot,
``gymnasium.make_vec("slider.gym:slider/Walking-v0", num_envs=64)`` many in one simulation.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
import torch
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from slider.artefacts.current import current_folder
from slider.artefacts.store import Store
from slider.composition.compose import compose
from slider.env.terms import checked, uses_library
from slider.env.vec_env import WalkingEnv, task_of
from slider.library.reader import MAKE_LIBRARY, STORE


class WalkingVectorEnv(VectorEnv):
    """Environment of the last training, walking or fine-tuning: N robots that track velocities.

    Observations (N, size), actions (N, 12) and rewards (N,) are those of the training with
    rsl_rl. A fall terminates an episode, its maximum length truncates it. The robot is reset in
    the same step; ``info["final_obs"]`` has the last observation of the episode.

    Args:
        num_envs: number of robots N.
        overrides: Hydra overrides, such as ``env/observation=...`` or ``experiment=robust``.
        conf: folder of the configuration.
        artefacts: store with the gait library, if the training needs one.
        library: path of a gait library to use instead of that of the store.
        threads: number of threads of the simulation.

    Attributes:
        task: the training task.

    Raises:
        UserError: the configuration is invalid, or there is no gait library yet.
    """

    metadata: ClassVar[dict[str, Any]] = {
        "autoreset_mode": AutoresetMode.SAME_STEP,
        "render_modes": [],
    }

    def __init__(
        self,
        num_envs: int = 1,
        overrides: Sequence[str] = (),
        conf: str | Path = "conf",
        artefacts: str | Path = "artefacts",
        library: str | Path | None = None,
        threads: int = 1,
    ) -> None:
        config = checked(compose(overrides, Path(conf)))
        train = replace(config.finetuning or config.train.walking, robots=num_envs)
        env = replace(config.env, sensing=train.sensing)
        if library is None and uses_library(env, train):
            store = Store(Path(artefacts))
            library = current_folder(store, "library", MAKE_LIBRARY) / STORE
        path = None if library is None else Path(library)
        self.task = task_of(config.robot, env, train, path)
        self._threads, self.num_envs = threads, num_envs
        self._start(train.seed)
        size, action, clip = len(self._observe()[0]), env.action, env.observation.clip
        self.single_observation_space = Box(-clip, clip, (size,), np.float32)
        self.single_action_space = Box(-action.clip, action.clip, (12,), np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Reset all robots; a seed restarts all random number generators."""
        super().reset(seed=seed)
        if seed is None:
            self._env.restart()
        else:
            self._start(seed)
        return self._observe(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Advance by one control period."""
        _, reward, _, extras = self._env.step(torch.as_tensor(np.asarray(actions)))
        truncated = extras["time_outs"].bool().numpy()
        terminated = self._env.fell.numpy()
        info: dict[str, Any] = {"log": {key: float(mean) for key, mean in extras["log"].items()}}
        if len(ended := np.flatnonzero(terminated | truncated)):
            info["final_obs"] = np.full(self.num_envs, None, dtype=object)
            for index in ended:
                info["final_obs"][index] = self._env.last[index].numpy()
            info["_final_obs"] = terminated | truncated
        return self._observe(), reward.numpy(), terminated, truncated, info

    def _start(self, seed: int) -> None:
        self.task = replace(self.task, train=replace(self.task.train, seed=seed))
        self._env = _Observed(self.task, self._threads)

    def _observe(self) -> np.ndarray:
        return self._env.get_observations()["policy"].numpy()


class _Observed(WalkingEnv):
    """Keeps which robots fell in a step, and the observations before the reset."""

    def _end_episodes(self, fell: torch.Tensor, state: Any) -> torch.Tensor:
        self.fell, self.last = fell, self.agent.observe(self._measured)
        return super()._end_episodes(fell, state)


class WalkingGymEnv(gymnasium.Env):
    """One robot of :class:`WalkingVectorEnv`, with its arguments except ``num_envs``."""

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}

    def __init__(self, **options: Any) -> None:
        self._many = WalkingVectorEnv(1, **options)
        self.observation_space = self._many.single_observation_space
        self.action_space = self._many.single_action_space

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Reset the robot."""
        super().reset(seed=seed)
        observations, info = self._many.reset(seed=seed)
        return observations[0], info

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Advance by one control period; call ``reset`` after the end of an episode."""
        observations, reward, fell, late, info = self._many.step(np.asarray(action)[None])
        last = info["final_obs"][0] if fell[0] or late[0] else observations[0]
        return last, float(reward[0]), bool(fell[0]), bool(late[0]), {"log": info["log"]}


gymnasium.register(
    "slider/Walking-v0",
    "slider.gym:WalkingGymEnv",
    vector_entry_point="slider.gym:WalkingVectorEnv",
)
