"""Small policies with random weights, as files."""

from pathlib import Path

import torch

from slider.control import POLICY_FILE
from slider.control.export import write_files
from slider.control.policy import Policy, PolicyNetwork, save_policy
from slider.env.interface import AgentInterface
from tests import shared
from tests.env.synthetic import config, gait_table

HIDDEN = (24, 16)


def make_policy(*overrides: str) -> Policy:
    """Untrained, with small actions, so that the robot moves and does not fall at once."""
    whole = config("experiment=test", *overrides)
    env = whole.env
    times = gait_table().times if env.phase.enabled else None
    reference = gait_table().joints if env.action.offset == "gait" else None
    layout = AgentInterface(whole.robot, env, 1, times, reference).observer.layout
    size = sum(layout.values())
    torch.manual_seed(0)
    network = PolicyNetwork(size, 12, HIDDEN, "elu")
    network.mean.copy_(0.1 * torch.randn(size))
    network.std.copy_(0.5 + torch.rand(size))
    training = {"seed": 1, "iteration": 20, "value": 0.25}
    return Policy(
        network.eval(), HIDDEN, "elu", layout, times, whole.robot, env, training, reference
    )


def write_policy(path: Path, *overrides: str) -> Policy:
    policy = make_policy(*overrides)
    save_policy(policy, path)
    return policy


@shared.shared
def exported() -> Path:
    """Folder of such a policy and its exported files, once per test session: do not change it."""
    folder = shared.new_folder()
    write_policy(folder / POLICY_FILE)
    estimator = config("experiment=test").env.estimator
    write_files(folder / POLICY_FILE, {"recipe": "abc"}, folder, estimator)
    return folder
