"""The baseline of a configuration: the controller, behind its observer where there is one."""

from dataclasses import replace

import numpy as np

from slider.config.control import MpcConfig
from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.control.mpc.clock import TickClock
from slider.control.mpc.observer import Observer
from slider.control.mpc.walker import MpcController
from slider.env.state import RobotState


class ObservingController:
    """The controller, told what its observer estimates."""

    def __init__(self, controller: MpcController, observer: Observer) -> None:
        self._controller, self._observer = controller, observer

    @property
    def clock(self) -> TickClock:
        """Cost of the parts of a tick."""
        return self._controller.clock

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start anew; see :class:`MpcController`."""
        self._observer.reset(state)
        self._controller.reset(state, velocity)

    def command(self, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on."""
        self._controller.command(velocity)

    def control(self, state: RobotState) -> np.ndarray:
        """Torques (N, 12) [N m or N] from measured states."""
        with self.clock.part("observer"):
            estimate = self._observer.estimate(state)
        torques = self._controller.control(estimate)
        self._observer.send(torques)
        return torques


Baseline = MpcController | ObservingController


def build_controller(
    robot: RobotConfig, config: MpcConfig, physics: PhysicsConfig, count: int, threads: int = 1
) -> Baseline:
    """The baseline for ``count`` robots.

    Args:
        robot: the nominal robot, not the plant.
        config: settings.
        physics: of the plant; the observer's model has the same.
        count: number of robots.
        threads: of the observer's simulation.
    """
    tick = replace(physics, substeps=config.substeps)
    controller = MpcController(robot, config, tick.substeps * tick.timestep)
    if config.observer is None:
        return controller
    return ObservingController(controller, Observer(robot, tick, config.observer, count, threads))
