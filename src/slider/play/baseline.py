"""The model-predictive baseline, steered while it walks."""

import numpy as np

from slider.control.mpc.walker import MpcController
from slider.core.config.control import MpcConfig
from slider.core.config.env import PlantConfig, StartNoise
from slider.core.config.robot import RobotConfig
from slider.env.episode import Episode
from slider.evaluation.baseline import build_plant
from slider.play.motion import Simulation, starts


class SteeredController(MpcController):
    """The baseline with a command that changes; an evaluation holds it constant."""

    def steer(self, velocity: np.ndarray) -> None:
        """Command ``velocity`` (1, 3) from the next tick on; see the base class."""
        self._command = velocity


def simulate_baseline(
    robot: RobotConfig, plant: PlantConfig, config: MpcConfig, noise: StartNoise, seed: int
) -> Simulation:
    """The baseline on torque drives, as its evaluation has it."""
    physics = build_plant(robot, plant.physics, config, 1)
    controller = SteeredController(robot, config, physics.period)
    episode = Episode(controller, physics, plant)
    start = starts(robot, noise, seed)
    return Simulation(episode, plant.control_period, start, controller.steer)
