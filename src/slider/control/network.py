"""The policy network as plain torch: normaliser, then a multilayer perceptron."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import torch
from torch import nn

UNVARIED = 1e-3  # an observation with a smaller standard deviation did not vary in training
ACTIVATIONS: dict[str, type[nn.Module]] = {
    "elu": nn.ELU,
    "relu": nn.ReLU,
    "tanh": nn.Tanh,
}


class PolicyNetwork(nn.Module):
    """Deterministic policy: observations (N, num_observations) → actions (N, num_actions)."""

    mean: torch.Tensor
    std: torch.Tensor

    def __init__(
        self, num_observations: int, num_actions: int, hidden: Sequence[int], activation: str
    ) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(num_observations))
        self.register_buffer("std", torch.ones(num_observations))
        sizes = [num_observations, *hidden, num_actions]
        layers: list[nn.Module] = []
        for inputs, outputs in pairwise(sizes):
            layers += [nn.Linear(inputs, outputs), ACTIVATIONS[activation]()]
        self.mlp = nn.Sequential(*layers[:-1])

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Actions of observations, normalised with the statistics of training."""
        return self.mlp((observations - self.mean) / self.std)


def from_actor(
    state: Mapping[str, torch.Tensor], hidden: Sequence[int], activation: str, epsilon: float
) -> PolicyNetwork:
    """Copy an rsl-rl actor's parameters.

    Args:
        state: ``state_dict`` of an ``MLPModel`` with observation normalisation.
        hidden: widths of its hidden layers.
        activation: name of its activation.
        epsilon: what its normaliser adds to the standard deviation.

    An observation that did not vary in training is not scaled: else a command that is new to the
    policy would reach its first layer a hundred times as large as it is.
    """
    weights = {k.removeprefix("mlp."): v for k, v in state.items() if k.startswith("mlp.")}
    num_observations = weights["0.weight"].shape[1]
    num_actions = weights[f"{2 * len(hidden)}.bias"].shape[0]  # an activation after each layer
    with torch.random.fork_rng(devices=[]):  # initial weights, overwritten below
        network = PolicyNetwork(num_observations, num_actions, hidden, activation)
    network.mlp.load_state_dict({k: v.clone() for k, v in weights.items()})
    network.mean.copy_(state["obs_normalizer._mean"].squeeze(0))
    std = state["obs_normalizer._std"].squeeze(0)
    network.std.copy_(torch.where(std < UNVARIED, 1.0, std) + epsilon)
    return network.eval()
