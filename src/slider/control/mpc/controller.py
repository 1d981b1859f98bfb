"""The model-predictive controller: footsteps on the pendulum, swing foot and whole-body QP."""

from slider.config.control import MpcConfig
from slider.config.robot import RobotConfig
from slider.control.mpc.steps import Steps
from slider.control.whole_body.controller import Surroundings, WalkingController


def mpc_controller(robot: RobotConfig, config: MpcConfig, period: float) -> WalkingController:
    """The baseline for a nominal robot, with ticks of ``period`` [s]."""
    around = Surroundings(robot, config, config.swing.search_velocity, period)
    return WalkingController(around, Steps(config, around))
