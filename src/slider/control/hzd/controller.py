"""The controller ``hzd``: gaits of the library, enforced by input-output linearisation as a QP."""

from slider.config.control import HzdConfig
from slider.config.robot import RobotConfig
from slider.control.hzd.gaits import GaitTables
from slider.control.hzd.steps import HzdSteps
from slider.control.whole_body.controller import Surroundings, WalkingController
from slider.library.reader import GaitLibrary
from slider.robot.knee_map import KneeLengths


def hzd_controller(
    robot: RobotConfig, config: HzdConfig, library: GaitLibrary, period: float
) -> WalkingController:
    """Virtual constraints of a library on a nominal robot, with ticks of ``period`` [s]."""
    around = Surroundings(robot, config, config.descent, period)
    gaits = GaitTables(library, around.model)
    return WalkingController(around, HzdSteps(config, gaits, KneeLengths.of(robot), around))
