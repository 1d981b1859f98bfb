"""Several GPUs of one machine: a process for each, as ``torchrun`` starts them.

rsl-rl finds its place among them in ``RANK``, ``LOCAL_RANK`` and ``WORLD_SIZE``, copies the weights
of the first process to the others, and averages gradients and normalisers.
"""

import os
from collections.abc import Callable
from typing import Any, TypeVar

from slider.core.errors import UserError

Result = TypeVar("Result")


def rank() -> int:
    """Rank of this process; 0 where it is the only one."""
    return int(os.environ.get("RANK", "0"))


def device_of(kind: str) -> str:
    """Torch's name of the device of this process: ``cpu``, or the GPU of its rank."""
    return kind if kind == "cpu" else f"{kind}:{os.environ.get('LOCAL_RANK', '0')}"


def wait_for_all() -> None:
    """Wait for all processes; if one fails, the launcher ends the others."""
    import torch

    if torch.distributed.is_initialized():
        torch.distributed.barrier()


def launch(processes: int, work: Callable[..., Result], *arguments: object) -> Result:
    """Do ``work`` in some processes, or in this one; return what the first of them returns.

    Arguments and results are pickled. If one process fails, the others are ended.

    Raises:
        UserError: one of them raised it.
        ChildFailedError: one failed otherwise; see its output.
    """
    if processes == 1:
        return work(*arguments)
    from torch.distributed.elastic.multiprocessing.errors import ChildFailedError  # takes long
    from torch.distributed.launcher.api import LaunchConfig, elastic_launch

    config = LaunchConfig(
        min_nodes=1,
        max_nodes=1,
        nproc_per_node=processes,
        run_id="training",
        rdzv_backend="c10d",
        rdzv_endpoint="localhost:0",
        max_restarts=0,
        monitor_interval=1,
    )
    try:
        return elastic_launch(config, work)(*arguments)[0]
    except ChildFailedError as error:
        number, failure = error.get_first_failure()
        message: Any = failure.message  # a record of elastic, or a text
        message = message["message"] if isinstance(message, dict) else message
        kind, _, text = message.partition(": ")
        if kind != UserError.__name__:
            raise
        raise UserError(f"process {number} of {processes}: {text}") from None
