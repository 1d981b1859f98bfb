"""The kernels that stages compute with, for those whose bytes depend on them."""

from dataclasses import replace
from functools import cache
from typing import Any

from slider.config.schema import Config
from slider.config.train import TrainConfig
from slider.core.numerics import Kernels, Mode, device, kernels, precision

ARRAYS = ("numpy", "blas")
"""Libraries of stages that compute with arrays."""
NETWORKS = (*ARRAYS, "aten", "mkl")
"""Of stages that evaluate networks."""
BFLOAT16 = (*NETWORKS, "onednn")
"""Of trainings whose update runs in bfloat16."""


def numerics(
    config: Config, libraries: tuple[str, ...] = ARRAYS, where: str = "cpu"
) -> dict[str, Any]:
    """A part of a section: what libraries compute with, there where the job will run.

    ``where`` is the device of torch.

    Raises:
        UserError: the processor cannot do what ``config`` wants.
    """
    return {"numerics": _numerics(config.numerics, libraries, where)}


def resolved(config: Config, train: TrainConfig) -> TrainConfig:
    """A training with the device and the precision that it will have in the place of ``auto``."""
    where = device(train.device)
    found = precision(train.ppo.precision, _kernels(config.numerics), where)
    return replace(train, device=where, ppo=replace(train.ppo, precision=found))


def of_training(config: Config, train: TrainConfig) -> dict[str, Any]:
    """What a resolved training computes with; the checks of its policies use the processor."""
    on_processor = train.ppo.precision == "bfloat16" and train.device == "cpu"
    return numerics(config, BFLOAT16 if on_processor else NETWORKS, train.device)


@cache
def _numerics(mode: Mode, libraries: tuple[str, ...], where: str) -> Kernels:
    of_torch = {"device": where} if "aten" in libraries else {}
    return of_torch | {name: _kernels(mode)[name] for name in libraries}


@cache
def _kernels(mode: Mode) -> Kernels:
    return kernels(mode)
