"""The checks of single gaits, one after the other, with the time that each takes."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from slider.config.gait import Posture
from slider.config.robot import RobotConfig
from slider.config.verification import CheckConfig
from slider.verification import dense, dynamics, plant, replay, roll
from slider.verification.pin_robot import build_robot
from slider.verification.stored import StoredGait

Values = dict[str, float]
Check = Callable[[StoredGait], Values]


@dataclass(frozen=True)
class Surroundings:
    """What gaits are checked against: the robot and what the optimisation was asked for."""

    robot: RobotConfig
    posture: Posture
    dynamics: str
    kinematic_map: str
    config: CheckConfig


def checks(given: Surroundings) -> dict[str, Check]:
    """Checks by name; each gives some of ``slider.verification.quantities``."""
    robot, config = given.robot, given.config
    floating = build_robot(robot, given.dynamics)
    machine = plant.Plant(robot)
    simulation = replay.Simulation(robot, config.replay)
    slides, variant = floating.coordinates.map, given.kinematic_map
    dense_check = partial(
        dense.between_nodes,
        pinocchio=floating,
        robot=robot,
        posture=given.posture,
        points=config.points,
    )
    return {
        "kinematics": partial(dynamics.kinematics, robot=floating),
        "channels": partial(dynamics.channels, slides=slides, variant=variant),
        "dynamics": partial(dynamics.inverse_dynamics, robot=floating),
        "impact": partial(dynamics.impact, robot=floating),
        "mean_velocity": dynamics.mean_velocity,
        "periodicity": dynamics.periodicity,
        "roll": partial(roll.one_step_integration, robot=floating, integrator=config.integrator),
        "return_map": partial(
            roll.open_loop,
            robot=floating,
            integrator=config.integrator,
            step=config.perturbation,
        ),
        "replay": partial(replay.replays, simulation=simulation, plant=machine),
        "plant": partial(plant.inverse_dynamics, plant=machine),
        "plant_impact": partial(plant.impact, plant=machine),
        "dense": dense_check,
        "legs": partial(dense.legs_apart, plant=machine, points=config.points),
    }


def check_gait(gait: StoredGait, table: dict[str, Check]) -> tuple[Values, dict[str, float]]:
    """All quantities of a gait, and the processor time of each check [s]."""
    values: Values = {}
    seconds = {}
    for name, check in table.items():
        start = time.process_time()
        values |= check(gait)
        seconds[name] = time.process_time() - start
    return values, seconds
