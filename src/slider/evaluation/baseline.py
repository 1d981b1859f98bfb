"""The stage ``baseline``: the model-predictive baseline at one command."""

from dataclasses import replace
from pathlib import Path

from slider.config.control import MpcConfig
from slider.config.convert import from_dict
from slider.config.env import PhysicsConfig, PlantConfig
from slider.config.robot import RobotConfig
from slider.control.mpc.controller import Baseline, build_controller
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.disturbance.draws import Disturbance
from slider.env.physics import BatchedPhysics
from slider.evaluation.protocol import Simulated, evaluate, read_protocol


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll the baseline out on torque drives, at its own, higher rate.

    Its nominal model is that of the section's robot, from which the disturbed plants differ.
    """
    protocol = read_protocol(section)
    simulated = simulate(section, protocol.count, protocol.disturbance, job.threads)
    summary = evaluate(protocol, simulated, out, job)
    assert isinstance(simulated.controller, Baseline)
    job.volatile["tick_us"] = simulated.controller.clock.microseconds()
    return summary


def simulate(section: Section, count: int, disturbance: Disturbance, threads: int = 1) -> Simulated:
    """The baseline on ``count`` robots."""
    robot = from_dict(RobotConfig, section["robot"])
    plant = from_dict(PlantConfig, section["plant"])
    config = from_dict(MpcConfig, section["control"])
    physics = build_plant(robot, plant.physics, config, count, disturbance, threads)
    controller = build_controller(robot, config, plant.physics, count, threads)
    return Simulated(controller, physics, plant)


def build_plant(
    robot: RobotConfig,
    config: PhysicsConfig,
    control: MpcConfig,
    count: int,
    disturbance: Disturbance | None = None,
    threads: int = 1,
) -> BatchedPhysics:
    """The same physics on torque drives, stepped from one control tick to the next."""
    settings = replace(config, substeps=control.substeps)
    return BatchedPhysics(robot, settings, count, threads, "torque", disturbance)
