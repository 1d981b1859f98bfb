"""A controller behind its observer."""

from collections.abc import Callable
from dataclasses import replace

from slider.config.control import AnyControl
from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.control.whole_body.controller import ModelBased, ObservingController, WalkingController
from slider.control.whole_body.observer import Observer

Build = Callable[..., WalkingController]
"""From the nominal robot, settings of one family and ``period``, that of the ticks [s]."""


def observed(
    build: Build,
    robot: RobotConfig,
    config: AnyControl,
    physics: PhysicsConfig,
    count: int,
    threads: int = 1,
) -> ModelBased:
    """A controller for ``count`` robots, behind the observer that its settings have, if any.

    Args:
        build: makes the controller.
        robot: the nominal robot, not the plant.
        config: settings.
        physics: of the plant; the observer's model has the same.
        count: number of robots.
        threads: of the observer's simulation.
    """
    tick = replace(physics, substeps=config.substeps)
    controller = build(robot, config, period=tick.substeps * tick.timestep)
    if config.observer is None:
        return controller
    return ObservingController(controller, Observer(robot, tick, config.observer, count, threads))
