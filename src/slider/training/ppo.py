"""The bridge to rsl-rl: our configuration as its dictionaries, its scalars to our tracker."""

from typing import Any

import torch
from rsl_rl.utils.log_writer import LogWriter
from tensordict import TensorDict

from slider.config.train import NetworkConfig, PpoConfig, TrainConfig
from slider.core.job import Tracker
from slider.env.vec_env import WalkingEnv
from slider.robot.names import MIRROR_PERMUTATION, MIRROR_SIGN
from slider.training.annealed_ppo import AnnealedPPO, NoiseBound

NORMALISER_EPSILON = 1e-2  # rsl-rl's EmpiricalNormalization adds it to the standard deviation
_NEVER = 10**9
# rsl-rl logs these against the wall clock instead of the iteration.
_SKIPPED_SUFFIX = "/time"
_VOLATILE = "Perf/"  # times and rates: no part of a result
ITERATION = "iteration"


def runner_config(
    train: TrainConfig, tracker: Tracker, curve: list[dict[str, float]]
) -> dict[str, Any]:
    """Configuration dictionary of ``OnPolicyRunner``; ``curve`` gets a row per iteration."""
    return {
        "num_steps_per_env": train.steps_per_iteration,
        "save_interval": _NEVER,  # checkpoints are ours
        "obs_groups": {"actor": ["policy"], "critic": ["policy"]},
        "logger": {"class_name": _writer_factory(tracker, curve)},
        "actor": {**_model(train.network), "distribution_cfg": _distribution(train.network)},
        "critic": _model(train.network),
        "algorithm": _algorithm(train),
    }


def _writer_factory(tracker: Tracker, curve: list[dict[str, float]]):
    """A function, since rsl-rl deep-copies its configuration and functions survive that."""

    def create(log_dir: str) -> TrackerLogWriter:
        return TrackerLogWriter(tracker, curve)

    return create


def _model(network: NetworkConfig) -> dict[str, Any]:
    return {
        "class_name": "MLPModel",
        "hidden_dims": list(network.hidden),
        "activation": network.activation,
        "obs_normalization": True,
    }


def _distribution(network: NetworkConfig) -> dict[str, Any]:
    return {
        "class_name": "GaussianDistribution",
        "init_std": network.initial_std,
        "std_type": "log",
        "std_range": (network.std_min, network.std_max),
    }


def _algorithm(train: TrainConfig) -> dict[str, Any]:
    ppo = train.ppo
    return {
        "class_name": AnnealedPPO,
        "actor_ema": ppo.actor_ema,
        "noise": NoiseBound(
            train.network.std_max,
            train.network.std_final,
            train.network.anneal_from,
            train.iterations,
        ),
        "num_learning_epochs": ppo.epochs,
        "num_mini_batches": ppo.mini_batches,
        "clip_param": ppo.clip,
        "gamma": ppo.gamma,
        "lam": ppo.lam,
        "value_loss_coef": ppo.value_coefficient,
        "entropy_coef": ppo.entropy_coefficient,
        "learning_rate": ppo.learning_rate,
        "schedule": ppo.schedule,
        "desired_kl": ppo.desired_kl,
        "max_grad_norm": ppo.max_grad_norm,
        "use_mixed_precision": _in_bfloat16(ppo),
        "symmetry_cfg": _symmetry(ppo),
    }


def _in_bfloat16(ppo: PpoConfig) -> bool:
    if ppo.precision == "auto":  # is another one on another machine: the recipe says which
        raise ValueError("expected float32 or bfloat16, found auto")
    return ppo.precision == "bfloat16"


class TrackerLogWriter(LogWriter):
    """Collects the scalars of an iteration and hands them over together.

    Args:
        tracker: gets all of them.
        curve: gets a row per iteration with what does not depend on the machine's speed.
    """

    def __init__(self, tracker: Tracker, curve: list[dict[str, float]]) -> None:
        self._tracker, self._curve = tracker, curve
        self._step = 0
        self._metrics: dict[str, float] = {}

    def add_scalar(self, tag: str, scalar_value: float, global_step: int) -> None:
        """Note one scalar; a new step flushes the last one."""
        if tag.endswith(_SKIPPED_SUFFIX):
            return
        if global_step != self._step:
            self._flush()
            self._step = global_step
        self._metrics[tag.strip("/")] = float(scalar_value)

    def stop(self) -> None:
        """Flush what is left."""
        self._flush()

    def _flush(self) -> None:
        if self._metrics:
            self._tracker.log_metrics(self._metrics, self._step)
            lasting = {k: v for k, v in self._metrics.items() if not k.startswith(_VOLATILE)}
            self._curve.append({ITERATION: self._step, **lasting})
        self._metrics = {}


def _symmetry(ppo: PpoConfig) -> dict[str, Any] | None:
    """Rsl-rl's ``symmetry_cfg`` of a configuration; none where it is off.

    Rsl-rl either learns from the reflected samples as well or adds a loss on the difference between
    the action of a reflected observation and the reflected action (Mittal et al., ICRA 2024).
    """
    if ppo.symmetry == "none":
        return None
    return {
        "data_augmentation_func": with_reflections,
        "use_data_augmentation": ppo.symmetry == "augmentation",
        "use_mirror_loss": ppo.symmetry == "loss",
        "mirror_loss_coeff": ppo.symmetry_weight,
    }


def with_reflections(
    env: WalkingEnv, obs: TensorDict | None, actions: torch.Tensor | None
) -> tuple[TensorDict | None, torch.Tensor | None]:
    """Observations (B, size) and actions (B, 12), each followed by its reflection (2 B, ·)."""
    if obs is not None:
        observer = env.agent.observer
        reflected = obs.clone()
        reflected["policy"] = _reflect(obs["policy"], observer.permutation, observer.sign)
        obs = TensorDict.cat([obs, reflected])
    if actions is not None:
        actions = torch.cat([actions, _reflect(actions, MIRROR_PERMUTATION, MIRROR_SIGN)])
    return obs, actions


def _reflect(values: torch.Tensor, permutation: Any, sign: Any) -> torch.Tensor:
    index = torch.as_tensor(permutation, dtype=torch.long, device=values.device)
    return values[:, index] * torch.as_tensor(sign, dtype=values.dtype, device=values.device)
