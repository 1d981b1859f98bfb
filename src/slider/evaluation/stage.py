"""The stage ``evaluation``: the learned policy at one command."""

from pathlib import Path

import torch

from slider.control.policy import PolicyController
from slider.control.policy_file import load_policy
from slider.core.config.convert import from_dict
from slider.core.config.env import EnvConfig
from slider.core.config.robot import RobotConfig
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.interface import AgentInterface
from slider.env.physics import BatchedPhysics
from slider.evaluation.protocol import evaluate, read_protocol


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll the policy out on position drives, once per control period."""
    torch.set_num_threads(job.threads)
    protocol = read_protocol(section)
    env = from_dict(EnvConfig, section["env"])
    controller = build_controller(inputs, protocol.robot, env, protocol.count)
    physics = BatchedPhysics(protocol.robot, env.physics, protocol.count, job.threads)
    return evaluate(protocol, controller, physics, env, out, job)


def build_controller(
    inputs: Inputs, robot: RobotConfig, env: EnvConfig, count: int
) -> PolicyController:
    """The policy of the walking stage for ``count`` robots.

    Raises:
        UserError: the policy is for other observations.
    """
    policy = load_policy(inputs["walking"][0] / "policy.pt")
    agent = AgentInterface(robot, env, count, policy.times)
    if list(agent.observer.layout.items()) != list(policy.observations.items()):  # order counts
        raise UserError(
            f"policy: expected the observations {agent.observer.layout}, "
            f"found {policy.observations}"
        )
    return PolicyController(policy.network, agent)
