"""The controllers of ``conf/control``: all that are not learned."""

from dataclasses import replace

from slider.config.control import HzdControlConfig, MpcConfig
from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.control.hzd.controller import EnforcedGaits, hzd_controller
from slider.control.mpc.controller import mpc_controller
from slider.control.whole_body.controller import ModelBased, ObservingController
from slider.control.whole_body.observer import Observer
from slider.core.errors import UserError


def build_controller(
    robot: RobotConfig,
    config: MpcConfig | HzdControlConfig,
    physics: PhysicsConfig,
    count: int,
    gaits: EnforcedGaits | None = None,
    threads: int = 1,
) -> ModelBased:
    """A controller for ``count`` robots.

    Args:
        robot: the nominal robot, not the plant.
        config: settings.
        physics: of the plant; the observer's model has the same.
        count: number of robots.
        gaits: where the controller walks by them.
        threads: of the observer's simulation.

    Raises:
        UserError: the controller walks by gaits, and there are none.
    """
    tick = replace(physics, substeps=config.substeps)
    period = tick.substeps * tick.timestep
    if isinstance(config, MpcConfig):
        controller = mpc_controller(robot, config, period)
    elif gaits is None:
        raise UserError("controller: expected gaits to walk by, found none")
    else:
        controller = hzd_controller(robot, config, gaits, period)
    if config.observer is None:
        return controller
    return ObservingController(controller, Observer(robot, tick, config.observer, count, threads))
