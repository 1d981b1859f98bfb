"""Small policies with random weights, as files."""

from pathlib import Path

import torch

from slider.control.policy import Policy, PolicyNetwork, save_policy
from slider.env.interface import AgentInterface
from tests.env.synthetic import config, gait_table

HIDDEN = (24, 16)


def make_policy(*overrides: str) -> Policy:
    """Untrained, with small actions, so that the robot moves and does not fall at once."""
    whole = config("experiment=test", *overrides)
    times = gait_table().times if whole.env.phase.enabled else None
    reference = gait_table().joints if whole.env.action.offset == "gait" else None
    layout = AgentInterface(whole.robot, whole.env, 1, times, reference).observer.layout
    size = sum(layout.values())
    torch.manual_seed(0)
    network = PolicyNetwork(size, 12, HIDDEN, "elu")
    network.mean.copy_(0.1 * torch.randn(size))
    network.std.copy_(0.5 + torch.rand(size))
    facts = {"seed": 1, "iteration": 20, "value": 0.25}
    return Policy(
        network.eval(), HIDDEN, "elu", layout, times, whole.robot, whole.env, facts, reference
    )


def write_policy(path: Path, *overrides: str) -> Policy:
    policy = make_policy(*overrides)
    save_policy(policy, path)
    return policy
