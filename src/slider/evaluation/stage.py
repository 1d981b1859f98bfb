"""The stages ``evaluation`` and ``sensitivity_policy``: the learned policy in the protocol.

The latter has another robot than the policy was trained on. The plant, its starts and its drives
are those of the changed robot. What the policy believes stays that of its training: nominal pose,
ranges of its joint targets, scales, reference gaits and clock.
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


def run_changed(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll the policy out at each command, with the results of each in a folder of its own."""
    torch.set_num_threads(job.threads)
    rates = []
    for command in section["commands"]:
        protocol = read_protocol(section | {"command": command})
        disturbance = protocol.disturbance
        simulated = simulate(section, inputs, protocol.count, disturbance, job.threads, True)
        folder = out / folder_name(command)
        folder.mkdir()
        rates.append(evaluate(protocol, simulated, folder, job)["success_rate"])
    return {"success_rate": rates}


def folder_name(command: float) -> str:
    """Folder of the results at a command [m/s]."""
    return f"{command:g}"


def simulate(
    section: Section,
    inputs: Inputs,
    count: int,
    disturbance: Disturbance,
    threads: int = 1,
    changed: bool = False,
    read: ReadUnderlying | None = None,
) -> Simulated:
    """The policy of the walking stage on ``count`` robots.

    On a ``changed`` one it keeps the model of its own. ``read`` makes the controller under the
    actions of a policy that has one.

    Raises:
        UserError: the policy is for other observations or actions.
    """
    robot, env = from_dict(RobotConfig, section["robot"]), from_dict(EnvConfig, section["env"])
    policy = load_policy(inputs["walking"][0] / POLICY_FILE)
    underlying = read(policy.underlying) if read else None
    physics = build_physics(robot, env.physics, count, threads, disturbance, underlying)
    agent = agent_of(policy, policy.robot if changed else robot, env, count, underlying)
    controller = PolicyController(policy.network, agent)
    return Simulated(controller, physics, env)
