"""The kernels that stages compute with, for those whose bytes depend on them."""

from dataclasses import replace
from functools import cache
from typing import Any

from slider.config.schema import Config
from slider.config.train import TrainConfig
from slider.core.numerics import Kernels, Mode, kernels, precision

ARRAYS = ("numpy", "blas")
"""Libraries of stages that compute with arrays."""
NETWORKS = (*ARRAYS, "aten", "mkl")
"""Of stages that evaluate networks."""
BFLOAT16 = (*NETWORKS, "onednn")
"""Of trainings whose update runs in bfloat16."""


def numerics(config: Config, libraries: tuple[str, ...] = ARRAYS) -> dict[str, Any]:
    """A part of a section: what libraries compute with, there where the job will run.

    Raises:
        UserError: the processor cannot do what ``config`` wants.
    """
    return {"numerics": _numerics(config.numerics, libraries)}


def with_precision(config: Config, train: TrainConfig) -> TrainConfig:
    """A training with the precision that it will have in the place of ``auto``."""
    found = precision(train.ppo.precision, _kernels(config.numerics))
    return replace(train, ppo=replace(train.ppo, precision=found))


@cache
def _numerics(mode: Mode, libraries: tuple[str, ...]) -> Kernels:
    device = {"device": "cpu"} if "aten" in libraries else {}  # torch computes there alone
    return device | {name: _kernels(mode)[name] for name in libraries}


@cache
def _kernels(mode: Mode) -> Kernels:
    return kernels(mode)
