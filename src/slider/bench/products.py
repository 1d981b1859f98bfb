"""The matrix products of PPO's update alone, which bound it from below."""

from collections.abc import Callable, Iterable

import torch
from torch.nn import Linear, Module


def products(
    networks: Iterable[Module], batch: int, repeats: int, dtype: torch.dtype
) -> Callable[[], None]:
    """A function that multiplies as an update does, on random numbers.

    Args:
        networks: multi-layer perceptrons that are differentiated by their weights.
        batch: samples of a mini-batch.
        repeats: mini-batches of an update.
        dtype: of the factors.
    """
    factors = []
    for network in networks:
        layers = [layer for layer in network.modules() if isinstance(layer, Linear)]
        for index, layer in enumerate(layers):
            like = {"dtype": dtype, "device": layer.weight.device}
            weights = layer.weight.detach().to(dtype)
            inputs = torch.randn(batch, layer.in_features, **like)
            gradients = torch.randn(batch, layer.out_features, **like)
            factors.append((inputs, weights, gradients, index > 0))

    def multiply() -> None:
        for _ in range(repeats):
            for inputs, weights, gradients, go_back in factors:
                torch.mm(inputs, weights.T)
                torch.mm(gradients.T, inputs)
                if go_back:  # nobody asks for the gradient of an observation
                    torch.mm(gradients, weights)

    return multiply
