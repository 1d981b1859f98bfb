"""rsl-rl's PPO with annealed noise and an averaged actor, and its configuration dictionaries.

Noise shifts the mean speed of a policy, so that a policy trained with noise tracks another speed
without it. Single updates change the mean speed at a command by a few per cent. The average of the
actors varies less (Polyak and Juditsky, 1992) and is exported.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import Any, cast

import torch
from rsl_rl.algorithms import PPO
from rsl_rl.models import MLPModel
from rsl_rl.utils.log_writer import LogWriter
from torch.nn import Module
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from slider.config.train import NetworkConfig, TrainConfig
from slider.core.job import LogMetrics

NORMALISER_EPSILON = 1e-2  # rsl-rl's EmpiricalNormalization adds it to the standard deviation
_NEVER = 10**9
_AVERAGE = "average_state_dict"


class AnnealedPPO(PPO):
    """PPO with bounded action noise and an exponential moving average of the actor.

    Args:
        actor_ema: decay of the average per update; at 0 the average is the actor.
        noise_bound: number of updates → largest standard deviation of the action noise.

    Other arguments are those of rsl-rl's ``PPO``, with a ``log`` standard deviation. Learning does
    not use the average.
    """

    def __init__(
        self,
        actor: MLPModel,
        *arguments: Any,
        actor_ema: float,
        noise_bound: Callable[[int], float],
        **settings: Any,
    ) -> None:
        super().__init__(actor, *arguments, **settings)
        self._noise_bound = noise_bound
        self._average = AveragedModel(
            actor, multi_avg_fn=get_ema_multi_avg_fn(actor_ema), use_buffers=True
        )

    @property
    def averaged_actor(self) -> Module:
        """The average actor; before the first update, the actor itself."""
        return self._average.module if self._average.n_averaged else self.get_policy()

    def update(self) -> dict[str, float]:
        """Update actor and critic, bound the noise, then update the average."""
        losses = super().update()
        actor = self.get_policy()
        bound = self._noise_bound(int(self._average.n_averaged) + 1)
        with torch.no_grad():
            cast(Any, actor).distribution.log_std_param.clamp_(max=math.log(bound))
        self._average.update_parameters(actor)
        return losses

    def save(self) -> dict:
        """State dictionary, including the average."""
        return {**super().save(), _AVERAGE: self._average.state_dict()}

    def load(self, loaded_dict: dict, load_cfg: dict | None, strict: bool) -> bool:
        """Load as ``PPO.load`` does; ``average`` in ``load_cfg`` also loads the average."""
        if load_cfg is None or load_cfg.get("average"):
            self._average.load_state_dict(loaded_dict[_AVERAGE], strict=strict)
        return super().load(loaded_dict, load_cfg, strict)


def runner_config(
    train: TrainConfig, log_metrics: LogMetrics, curve: list[dict[str, float]]
) -> dict[str, Any]:
    """Configuration dictionary of ``OnPolicyRunner``; ``curve`` gets a row per iteration."""
    network = train.network
    model = {
        "class_name": "MLPModel",
        "hidden_dims": list(network.hidden),
        "activation": network.activation,
        "obs_normalization": True,
    }
    distribution = {
        "class_name": "GaussianDistribution",
        "init_std": network.initial_std,
        "std_type": "log",
        "std_range": (network.std_min, network.std_max),
    }
    return {
        "num_steps_per_env": train.steps_per_iteration,
        "save_interval": _NEVER,  # checkpoints are ours
        "obs_groups": {"actor": ["policy"], "critic": ["policy"]},
        # rsl-rl deep-copies its configuration: a function survives that, a writer would not.
        "logger": {"class_name": lambda log_dir: MetricsWriter(log_metrics, curve)},
        "actor": {**model, "distribution_cfg": distribution},
        "critic": dict(model),
        "algorithm": _algorithm(train),
    }


def _algorithm(train: TrainConfig) -> dict[str, Any]:
    ppo = train.ppo
    return {
        "class_name": AnnealedPPO,
        "actor_ema": ppo.actor_ema,
        "noise_bound": partial(_noise_bound, train.network, train.iterations),
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
        "use_mixed_precision": ppo.precision == "bfloat16",
    }


def _noise_bound(network: NetworkConfig, updates: int, update: int) -> float:
    """Bound after ``update`` of the ``updates``: ``std_max``, then geometric to ``std_final``."""
    begin = network.anneal_from * updates
    share = (update - begin) / max(updates - begin, 1.0)
    return network.std_max * (network.std_final / network.std_max) ** min(max(share, 0.0), 1.0)


class MetricsWriter(LogWriter):
    """Collects the scalars of an iteration and passes them on together.

    ``log_metrics`` gets all, ``curve`` a row of those that do not depend on the machine's speed.
    """

    def __init__(self, log_metrics: LogMetrics, curve: list[dict[str, float]]) -> None:
        self._log_metrics, self._curve = log_metrics, curve
        self._step = 0
        self._metrics: dict[str, float] = {}

    def add_scalar(self, tag: str, scalar_value: float, global_step: int) -> None:
        """Store one scalar; the first one of a new step flushes those of the last step."""
        if tag.endswith("/time"):  # against the wall clock instead of the iteration
            return
        if global_step != self._step:
            self.stop()
            self._step = global_step
        self._metrics[tag.strip("/")] = float(scalar_value)

    def stop(self) -> None:
        """Pass on the scalars of the last iteration."""
        if self._metrics:
            self._log_metrics(self._metrics, self._step)
            lasting = {k: v for k, v in self._metrics.items() if not k.startswith("Perf/")}
            self._curve.append({"iteration": self._step, **lasting})
        self._metrics = {}
