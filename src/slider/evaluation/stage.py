"""The stage ``evaluation``: the learned policy at one command."""

from pathlib import Path

import torch

from slider.config.convert import from_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.control.agent import agent_of
from slider.control.policy import PolicyController
from slider.control.policy_file import load_policy
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.disturbance.draws import Disturbance
from slider.env.physics import BatchedPhysics
from slider.evaluation.protocol import Simulated, evaluate, read_protocol


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll the policy out on position drives, once per control period."""
    torch.set_num_threads(job.threads)
    protocol = read_protocol(section)
    simulated = simulate(section, inputs, protocol.count, protocol.disturbance, job.threads)
    return evaluate(protocol, simulated, out, job)


def simulate(
    section: Section, inputs: Inputs, count: int, disturbance: Disturbance, threads: int = 1
) -> Simulated:
    """The policy of the walking stage on ``count`` robots.

    Raises:
        UserError: the policy is for other observations or actions.
    """
    robot, env = from_dict(RobotConfig, section["robot"]), from_dict(EnvConfig, section["env"])
    physics = BatchedPhysics(robot, env.physics, count, threads, disturbance=disturbance)
    policy = load_policy(inputs["walking"][0] / "policy.pt")
    controller = PolicyController(policy.network, agent_of(policy, robot, env, count))
    return Simulated(controller, physics, env)
