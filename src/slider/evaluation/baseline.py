"""The stage ``baseline``: a controller of ``conf/control`` at one command.

Each family has an entry point of its own: a change of one evaluates no other anew.
"""

from dataclasses import replace
from pathlib import Path

from slider.config.control import FAMILIES, AnyControl
from slider.config.convert import from_dict
from slider.config.env import PhysicsConfig, PlantConfig
from slider.config.robot import RobotConfig
from slider.control.whole_body.controller import ModelBased
from slider.control.whole_body.observed import Build, observed
from slider.core.job import Job, Section, Summary
from slider.env.disturbance.draws import Disturbance
from slider.env.physics import BatchedPhysics
from slider.evaluation.protocol import Simulated, evaluate, read_protocol


def run(section: Section, out: Path, job: Job, build: Build) -> Summary:
    """Roll a controller out on torque drives, at its own, higher rate.

    Its nominal model is that of the section's robot, from which the disturbed plants differ.
    """
    protocol = read_protocol(section)
    simulated = simulate(section, build, protocol.count, protocol.disturbance, job.threads)
    summary = evaluate(protocol, simulated, out, job)
    assert isinstance(simulated.controller, ModelBased)
    job.volatile["tick_us"] = simulated.controller.clock.microseconds()
    return summary


def simulate(
    section: Section, build: Build, count: int, disturbance: Disturbance, threads: int = 1
) -> Simulated:
    """The controller on ``count`` robots."""
    robot = from_dict(RobotConfig, section["robot"])
    plant = from_dict(PlantConfig, section["plant"])
    config = from_dict(FAMILIES[section["control"]["family"]], section["control"])
    physics = build_plant(robot, plant.physics, config, count, disturbance, threads)
    controller = observed(build, robot, config, plant.physics, count, threads)
    return Simulated(controller, physics, plant)


def build_plant(
    robot: RobotConfig,
    config: PhysicsConfig,
    control: AnyControl,
    count: int,
    disturbance: Disturbance | None = None,
    threads: int = 1,
) -> BatchedPhysics:
    """The same physics on torque drives, stepped from one control tick to the next."""
    settings = replace(config, substeps=control.substeps)
    return BatchedPhysics(robot, settings, count, threads, "torque", disturbance)
