"""The stage ``evaluation``: the learned policy in the protocol.

A study may evaluate it on another robot than it was trained on. Plant, starts and drives are then
those of the changed robot; the policy keeps the nominal pose, the ranges of joint targets, scales,
reference gaits and clock of its training.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import torch

from slider.config.convert import from_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.control import POLICY_FILE
from slider.control.agent import agent_of
from slider.control.policy import PolicyController
from slider.control.policy_file import load_policy
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.disturbance.draws import Disturbance
from slider.env.underlying import Underlying, build_physics
from slider.evaluation.protocol import Simulated, evaluate, read_protocol

ReadUnderlying = Callable[[Mapping[str, Any] | None], Underlying | None]
"""The controller under the actions from what a policy file has of it, if anything."""


def run(
    section: Section, inputs: Inputs, out: Path, job: Job, read: ReadUnderlying | None = None
) -> Summary:
    """Roll the policy out on position drives, once per control period."""
    torch.set_num_threads(job.threads)
    protocol = read_protocol(section)
    simulated = simulate(
        section, inputs, protocol.count, protocol.disturbance, job.threads, read=read
    )
    return evaluate(protocol, simulated, out, job)


def simulate(
    section: Section,
    inputs: Inputs,
    count: int,
    disturbance: Disturbance,
    threads: int = 1,
    read: ReadUnderlying | None = None,
) -> Simulated:
    """The policy of the walking stage on ``count`` robots.

    ``read`` makes the controller under the actions of a policy that has one.

    Raises:
        UserError: the policy is for other observations or actions.
    """
    robot, env = from_dict(RobotConfig, section["robot"]), from_dict(EnvConfig, section["env"])
    policy = load_policy(inputs["walking"][0] / POLICY_FILE)
    underlying = read(policy.underlying) if read else None
    physics = build_physics(robot, env.physics, count, threads, disturbance, underlying)
    agent = agent_of(policy, policy.robot, env, count, underlying)
    controller = PolicyController(policy.network, agent)
    return Simulated(controller, physics, env)
