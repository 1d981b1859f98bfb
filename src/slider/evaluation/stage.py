"""The stages ``evaluation`` and ``baseline``: roll controllers out."""

from pathlib import Path

import torch

from slider.config.control import FAMILIES
from slider.config.convert import from_dict
from slider.config.env import EnvConfig, PlantConfig
from slider.config.robot import RobotConfig
from slider.control import POLICY_FILE
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.model_based import build_controller, build_plant
from slider.control.policy import PolicyController, agent_of
from slider.control.policy_file import load_policy
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.disturbance import Disturbance
from slider.env.physics import BatchedPhysics
from slider.evaluation.protocol import Simulated, evaluate, read_protocol


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll the policy out on position drives, once per control period."""
    torch.set_num_threads(job.threads)
    protocol = read_protocol(section)
    simulated = simulate(section, inputs, protocol.count, protocol.disturbance, job.threads)
    return evaluate(protocol, simulated, out, job)


def run_baseline(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll a controller of ``conf/control`` out on torque drives, at its own, higher rate.

    Its nominal model is that of the section's robot, from which the disturbed plants differ.
    """
    protocol = read_protocol(section)
    disturbance, threads = protocol.disturbance, job.threads
    simulated = simulate_baseline(section, inputs, protocol.count, disturbance, threads)
    return evaluate(protocol, simulated, out, job)


def simulate(
    section: Section,
    inputs: Inputs,
    count: int,
    disturbance: Disturbance,
    threads: int = 1,
) -> Simulated:
    """The policy of the walking stage on ``count`` robots.

    A study may evaluate it on another robot than its training's. Plant, starts and drives are then
    those of the changed robot; the policy keeps nominal pose, ranges of joint targets, scales,
    reference gaits and clock of its training.

    Raises:
        UserError: the policy is for other observations or actions.
    """
    robot, env = from_dict(RobotConfig, section["robot"]), from_dict(EnvConfig, section["env"])
    policy = load_policy(inputs["walking"][0] / POLICY_FILE)
    physics = BatchedPhysics(robot, env.physics, count, threads, disturbance=disturbance)
    agent = agent_of(policy, policy.robot, env, count)
    return Simulated(PolicyController(policy.network, agent), physics, env)


def simulate_baseline(
    section: Section, inputs: Inputs, count: int, disturbance: Disturbance, threads: int = 1
) -> Simulated:
    """A controller of ``conf/control`` on ``count`` robots."""
    robot = from_dict(RobotConfig, section["robot"])
    plant = from_dict(PlantConfig, section["plant"])
    config = from_dict(FAMILIES[section["control"]["family"]], section["control"])
    physics = build_plant(robot, plant.physics, config, count, disturbance, threads)
    gaits = EnforcedGaits.of(section, inputs)
    controller = build_controller(robot, config, plant.physics, count, gaits, threads)
    return Simulated(controller, physics, plant)
