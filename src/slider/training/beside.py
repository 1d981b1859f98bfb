"""The critic on a thread of its own beside the actor: two cores learn, with the bits of one.

rsl-rl's PPO calls the actor and then the critic on the same observations, and differentiates the
sum of their losses. Neither network has a part in the other's numbers, so both can be computed and
differentiated at once. Each is on one thread, with the same operations in the same order as alone.
"""

from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Any
from weakref import WeakMethod, finalize

import torch
from torch.autograd.graph import register_multi_grad_hook
from torch.nn import Module


def set_up_thread() -> None:
    """One thread of torch for the present one: sums depend on their number; no denormal numbers."""
    torch.set_num_threads(1)
    torch.set_flush_denormal(True)


def compute_beside(actor: Module, critic: Module) -> None:
    """From now on compute the critic beside the actor, on the processor.

    Args:
        actor: a call with ``stochastic_output`` starts the critic on the same observations.
        critic: a call with other observations is computed as before.
    """
    _Beside(actor, critic)


class _Beside:
    """The critic's thread, and what it computes: values of some observations, then gradients."""

    def __init__(self, actor: Module, critic: Module) -> None:
        self._thread = ThreadPoolExecutor(1, "critic", initializer=set_up_thread)
        self._alone = critic.forward
        self._observations: Any = None
        self._values: Future[torch.Tensor]
        self._gradients: Future[None] | None = None
        actor.register_forward_pre_hook(self._start, with_kwargs=True)
        critic.forward = self._forward  # type: ignore[method-assign]
        wait: Any = WeakMethod(self._wait)  # no garbage collection finds a cycle through torch
        hook = register_multi_grad_hook(list(actor.parameters()), lambda found: wait()(found))
        finalize(self, hook.remove)

    def _start(self, _: Module, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> None:
        if named.get("stochastic_output"):
            self._observations = arguments[0]
            self._values = self._thread.submit(self._compute, arguments[0], *_modes())

    def _compute(
        self, observations: Any, inference: bool, grad: bool, autocast: bool, dtype: torch.dtype
    ) -> torch.Tensor:
        torch.set_autocast_enabled("cpu", autocast)  # the end of a context would empty the actor's
        torch.set_autocast_dtype("cpu", dtype)  # cache of weights, which all threads share
        with torch.inference_mode(inference), torch.set_grad_enabled(grad):
            return self._alone(observations)

    def _forward(self, observations: Any, **named: Any) -> torch.Tensor:
        if observations is not self._observations:
            return self._alone(observations, **named)
        self._observations, values = None, self._values.result()
        if not values.requires_grad:
            return values
        return _Handover.apply(values.detach().requires_grad_(), partial(self._go_back, values))

    def _go_back(self, values: torch.Tensor, gradient: torch.Tensor) -> None:
        """Begin with the gradients of the critic's parameters."""
        self._gradients = self._thread.submit(_differentiate, values, gradient)

    def _wait(self, _: Any) -> None:
        """The actor's gradients are there: the critic's have to be before anyone looks at them."""
        if self._gradients is None:
            raise RuntimeError("expected the critic's loss in the differentiated sum, found none")
        self._gradients.result()
        self._gradients = None


def _differentiate(values: torch.Tensor, gradient: torch.Tensor) -> None:
    torch.set_autocast_enabled("cpu", False)  # as in the actor's thread by then
    values.backward(gradient)


def _modes() -> tuple[bool, bool, bool, torch.dtype]:
    """What torch keeps per thread: inference mode, gradients, autocast and its type."""
    autocast = torch.is_autocast_enabled("cpu"), torch.get_autocast_dtype("cpu")
    return torch.is_inference_mode_enabled(), torch.is_grad_enabled(), *autocast


class _Handover(torch.autograd.Function):
    """The values in the graph of the losses; the gradient that comes back goes to their thread."""

    @staticmethod
    def forward(ctx: Any, leaf: torch.Tensor, go_back: Callable[[torch.Tensor], None]) -> Any:
        ctx.go_back = go_back
        return leaf.clone()

    @staticmethod
    def backward(ctx: Any, gradient: torch.Tensor) -> Any:
        ctx.go_back(gradient)
        return None, None
