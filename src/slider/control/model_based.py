"""The controllers of ``conf/control``: all that are not learned."""

from dataclasses import replace

from slider.config.control import HzdConfig, MpcConfig
from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.control.hzd.controller import hzd_controller
from slider.control.mpc.controller import mpc_controller
from slider.control.whole_body.controller import ModelBased, ObservingController
from slider.control.whole_body.observer import Observer
from slider.core.errors import UserError
from slider.library.reader import GaitLibrary


def build_controller(
    robot: RobotConfig,
    config: MpcConfig | HzdConfig,
    physics: PhysicsConfig,
    count: int,
    library: GaitLibrary | None = None,
    threads: int = 1,
) -> ModelBased:
    """A controller for ``count`` robots.

    Args:
        robot: the nominal robot, not the plant.
        config: settings.
        physics: of the plant; the observer's model has the same.
        count: number of robots.
        library: gaits, where the controller walks by them.
        threads: of the observer's simulation.

    Raises:
        UserError: the controller walks by gaits, and there is no library.
    """
    tick = replace(physics, substeps=config.substeps)
    period = tick.substeps * tick.timestep
    if isinstance(config, MpcConfig):
        controller = mpc_controller(robot, config, period)
    elif library is None:
        raise UserError("controller: expected a gait library to walk by, found none")
    else:
        controller = hzd_controller(robot, config, library, period)
    if config.observer is None:
        return controller
    return ObservingController(controller, Observer(robot, tick, config.observer, count, threads))
