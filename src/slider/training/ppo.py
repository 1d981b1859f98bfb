"""Our configuration in rsl-rl's words."""

from typing import Any

import torch

from slider.config.train import NetworkConfig, TrainConfig
from slider.core.job import Tracker
from slider.training.annealed_ppo import AnnealedPPO
from slider.training.log_writer import TrackerLogWriter
from slider.training.noise import NoiseBound
from slider.training.symmetry import symmetry_config

NORMALISER_EPSILON = 1e-2  # rsl-rl's EmpiricalNormalization adds it to the standard deviation
_NEVER = 10**9


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
        "use_mixed_precision": use_bfloat16(ppo.precision),
        "symmetry_cfg": symmetry_config(ppo),
    }


def use_bfloat16(precision: str) -> bool:
    """Whether the update runs in bfloat16; without hardware support it would be 15 times slower."""
    if precision == "auto":
        return torch.cpu._is_avx512_bf16_supported() or torch.cpu._is_amx_tile_supported()
    return precision == "bfloat16"
