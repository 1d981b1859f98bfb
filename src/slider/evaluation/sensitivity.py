"""The stage ``sensitivity_policy``: a policy on a robot other than the one it was trained on.

The plant, its starts and its drives are those of the changed robot. What the policy believes stays
that of its training: nominal pose, ranges of its joint targets, scales, reference gaits and clock.
"""

from pathlib import Path

import torch

from slider.config.convert import from_dict
from slider.config.env import EnvConfig
from slider.control.agent import agent_of
from slider.control.policy import PolicyController
from slider.control.policy_file import Policy, load_policy
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.physics import BatchedPhysics
from slider.evaluation.protocol import Protocol, Simulated, evaluate, read_protocol


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll the policy out at each command, with the records of each in a folder of its own.

    Raises:
        UserError: the policy is for other observations or actions.
    """
    torch.set_num_threads(job.threads)
    policy = load_policy(inputs["walking"][0] / "policy.pt")
    env = from_dict(EnvConfig, section["env"])
    found = []
    for command in section["commands"]:
        protocol = read_protocol(section | {"command": command})
        simulated = simulate(policy, protocol, env, job.threads)
        folder = out / folder_name(command)
        folder.mkdir()
        found.append(evaluate(protocol, simulated, folder, job))
    return {"success_rate": [summary["success_rate"] for summary in found]}


def folder_name(command: float) -> str:
    """Folder of the records at a command [m/s]."""
    return f"{command:g}"


def simulate(policy: Policy, protocol: Protocol, env: EnvConfig, threads: int = 1) -> Simulated:
    """The policy, believing in its own robot, on the protocol's robots.

    Raises:
        UserError: the policy is for other observations or actions.
    """
    physics = BatchedPhysics(
        protocol.robot, env.physics, protocol.count, threads, disturbance=protocol.disturbance
    )
    agent = agent_of(policy, policy.robot, env, protocol.count)
    return Simulated(PolicyController(policy.network, agent), physics, env)
