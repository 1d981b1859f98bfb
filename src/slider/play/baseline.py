"""The model-predictive baseline."""

from slider.config.control import MpcConfig
from slider.config.disturbance import DisturbanceConfig
from slider.config.env import PlantConfig, StartNoise
from slider.config.robot import RobotConfig
from slider.control.mpc.baseline import build_controller
from slider.env.disturbance.draws import Disturbance
from slider.env.episode import Episode
from slider.evaluation.baseline import build_plant
from slider.play.motion import Simulation, starts


def simulate_baseline(
    robot: RobotConfig,
    plant: PlantConfig,
    config: MpcConfig,
    noise: StartNoise,
    seed: int,
    disturbance: DisturbanceConfig,
) -> Simulation:
    """The baseline on torque drives, as its evaluation has it."""
    physics = build_plant(robot, plant.physics, config, 1, Disturbance(disturbance, (seed,)))
    controller = build_controller(robot, config, plant.physics, 1)
    episode = Episode(controller, physics, plant)
    return Simulation(episode, plant.control_period, starts(robot, noise, seed))
