"""One robot, step by step, as people watch it: what a video and the viewer are made of."""

from dataclasses import dataclass

import numpy as np

from slider.config.env import EnvConfig, PlantConfig
from slider.env import terminations
from slider.env.physics import BatchedPhysics
from slider.env.rollout import Controller, run_ticks
from slider.env.state import RobotState


@dataclass(frozen=True)
class Frame:
    """One instant.

    Attributes:
        time: since the start [s].
        qpos: base pose and joint positions (19,).
        velocity: forward and leftward velocity of the base (2,) [m/s], heading frame.
        failed: a termination of the protocol holds.
    """

    time: float
    qpos: np.ndarray
    velocity: np.ndarray
    failed: bool


class Episode:
    """A controller and one simulated robot; see :mod:`slider.env.rollout` for many at once."""

    def __init__(
        self, controller: Controller, physics: BatchedPhysics, config: EnvConfig | PlantConfig
    ) -> None:
        self._controller, self._physics, self._config = controller, physics, config
        self._ticks = round(config.control_period / physics.period)
        self._state: RobotState = physics.read()
        self._steps = 0

    def start(self, qpos: np.ndarray, qvel: np.ndarray, velocity: np.ndarray) -> Frame:
        """Place the robot at positions (1, 19) and velocities (1, 18).

        Args:
            qpos: base pose and joint positions.
            qvel: base and joint velocities.
            velocity: command (1, 3): vx, vy [m/s], yaw rate [rad/s].
        """
        self._physics.reset(np.arange(1), qpos, qvel)
        self._state, self._steps = self._physics.read(), 0
        self._controller.reset(self._physics.measure(self._state), velocity)
        return self._frame()

    def set_velocity(self, velocity: np.ndarray) -> None:
        """Command ``velocity`` (1, 3) from the next step on."""
        self._controller.set_velocity(velocity)

    def step(self) -> Frame:
        """Simulate one control period."""
        self._state, *_ = run_ticks(self._controller, self._physics, self._state, self._ticks)
        self._steps += 1
        return self._frame()

    def push(self, velocity: np.ndarray) -> None:
        """Add to the base's velocity (2,) in the world [m/s], as an impulse on it would."""
        self._physics.qvel[0, :2] += velocity

    def _frame(self) -> Frame:
        failed = terminations.failed(self._state, self._config.termination.terms)
        return Frame(
            time=self._steps * self._config.control_period,
            qpos=self._state.qpos[0],
            velocity=self._state.heading_velocity[0].copy(),
            failed=bool(failed[0]),
        )
