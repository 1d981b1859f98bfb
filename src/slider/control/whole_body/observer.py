"""State observer: predicts the state of the robot when the drives receive the torques.

A Luenberger observer with the nominal robot in MuJoCo, contacts included: each tick it simulates
the torques that act now, corrects its estimate by the measurement, and simulates the torques that
the delay still holds back. It knows the delay and the torques sent, but not the plant's masses,
motors, friction and pushes.
"""

from collections import deque
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from slider.config.control import ObserverConfig
from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.env.physics import BatchedPhysics
from slider.env.starts import multiply_quaternions
from slider.env.state import RobotState
from slider.robot import names


class Observer:
    """Estimates the states of N robots from noisy ones.

    The ``robot`` is the nominal one, not the plant. Its ``physics`` have the period of a tick.
    """

    def __init__(
        self,
        robot: RobotConfig,
        physics: PhysicsConfig,
        config: ObserverConfig,
        count: int,
        threads: int = 1,
    ) -> None:
        self._config = config
        self._model = BatchedPhysics(robot, physics, count, threads, "torque", instruments=False)
        self._ticks = round(config.delay / self._model.period)
        self._robots = np.arange(count)

    def reset(self, measured: RobotState) -> None:
        """Start from a measured state; torques are zero until the first ones arrive."""
        self._qpos, self._qvel = measured.qpos, measured.qvel
        self._inactive = np.zeros(measured.num_robots, dtype=bool)
        none = np.zeros((len(self._robots), names.NUM_JOINTS))
        self._under_way = deque([none] * self._ticks)
        self._acting: np.ndarray | None = None

    def deactivate(self, robots: np.ndarray) -> None:
        """Stop estimating the states of ``robots`` (N,)."""
        self._inactive |= robots

    def estimate(self, measured: RobotState) -> RobotState:
        """Predict the state in which the next torques will act, from the measured one."""
        if self._acting is not None:
            self._simulate([self._acting])
            position, velocity = self._config.position, self._config.velocity
            turn = rotation_between(self._qpos[:, 3:7], measured.quaternion)
            qpos = self._qpos + position * (measured.qpos - self._qpos)
            qpos[:, 3:7] = rotate(self._qpos[:, 3:7], position * turn)
            self._qpos = qpos
            self._qvel = self._qvel + velocity * (measured.qvel - self._qvel)
        if not self._under_way:  # contact flags are the measured ones
            self._model.reset(self._robots, self._qpos, self._qvel)
            return replace(self._model.read(), foot_forces=measured.foot_forces)
        qpos, qvel = self._qpos, self._qvel
        self._simulate(self._under_way)
        self._qpos, self._qvel = qpos, qvel
        return self._model.read()

    def send(self, torques: np.ndarray) -> None:
        """Store the torques (N, 12) that were sent after the last estimate."""
        self._under_way.append(torques)
        self._acting = self._under_way.popleft()

    def _simulate(self, inputs: Iterable[np.ndarray]) -> None:
        """Advance the estimate by one tick for each of the torques (N, 12)."""
        self._model.reset(self._robots, self._qpos, self._qvel)
        self._model.deactivate(self._inactive)
        for torques in inputs:
            self._model.step(torques)
        self._qpos, self._qvel = self._model.qpos.copy(), self._model.qvel.copy()


def rotation_between(old: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Rotation vectors (N, 3) [rad] of old's axes that turn quaternions old (N, 4) into new."""
    inverse = old * np.array([1.0, -1.0, -1.0, -1.0])
    difference = multiply_quaternions(inverse, new)
    sine = np.linalg.norm(difference[:, 1:], axis=1)
    angle = 2.0 * np.arctan2(sine, np.abs(difference[:, 0]))
    scale = np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)
    return difference[:, 1:] * (np.copysign(scale, difference[:, 0]))[:, None]


def rotate(quaternion: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Quaternions (N, 4) turned by rotation vectors (N, 3) [rad] of their own axes."""
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    axis = vectors / np.maximum(angle, 1e-12)
    step = np.concatenate([np.cos(angle / 2), np.sin(angle / 2) * axis], axis=1)
    return multiply_quaternions(quaternion, step)
