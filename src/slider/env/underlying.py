"""A model-based controller under the actions: what the environment asks of it, and its plant."""

from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.env.disturbance.draws import Disturbance
from slider.env.physics import BatchedPhysics
from slider.env.state import RobotState

NOBODY = -1  # no stance foot: at rest on both feet


class UnderlyingController(Protocol):
    """Torques of N robots, once per tick, with a memory that can be reset robot by robot."""

    @property
    def phase(self) -> np.ndarray:
        """Of the walk at the last tick (N,) in [0, 1): left stance below 0.5."""
        ...

    @property
    def halted(self) -> np.ndarray:
        """Whether a robot makes no steps (N,)."""
        ...

    def allocate(self, count: int) -> None:
        """Memory of ``count`` robots, none of which has started."""

    def restart(
        self,
        robots: np.ndarray,
        state: RobotState,
        velocity: np.ndarray,
        heading: np.ndarray,
        stance: np.ndarray,
    ) -> None:
        """Start ``robots`` (n,) anew; the others go on.

        Args:
            robots: indices.
            state: of all N robots.
            velocity: commands (n, 3): vx, vy [m/s], yaw rate [rad/s].
            heading: desired yaw (n,) [rad].
            stance: foot (n,) that begins a step of a walk at the command, or ``NOBODY``.
        """

    def command(self, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on."""

    def control(self, state: RobotState) -> np.ndarray:
        """Torques (N, 12) [N m or N]."""
        ...


class Underlying(Protocol):
    """What such a controller is made of."""

    @property
    def substeps(self) -> int:
        """Simulation steps per tick."""
        ...

    def controller(self, robot: RobotConfig, period: float) -> UnderlyingController:
        """A controller with a model of ``robot`` and ticks of ``period`` [s]."""
        ...

    def plain(self) -> dict[str, Any]:
        """All of it as numbers, texts and tensors, for the file of a policy."""
        ...


def build_physics(
    robot: RobotConfig,
    config: PhysicsConfig,
    count: int,
    threads: int = 1,
    disturbance: Disturbance | None = None,
    underlying: Underlying | None = None,
    instruments: bool = True,
) -> BatchedPhysics:
    """Position drives, or the torque drives of a controller under the actions, tick by tick."""
    if underlying is None:
        return BatchedPhysics(
            robot, config, count, threads, disturbance=disturbance, instruments=instruments
        )
    settings = replace(config, substeps=underlying.substeps)
    return BatchedPhysics(robot, settings, count, threads, "torque", disturbance, instruments)
