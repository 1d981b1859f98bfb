"""Commands from keyboard or browser; written by one thread, read by another."""

from collections.abc import Sequence

import numpy as np

from slider.robot.scene import CAMERAS

BACKWARD, SIDEWAYS, TURNING = 1.0, 0.5, 1.0  # highest commands [m/s], [m/s], [rad/s]
PUSH = 0.4  # change of the base's velocity [m/s]


class Control:
    """Command, pause, camera, and requests that are met once.

    Args:
        velocity: first command.
        top: highest forward command [m/s].

    Attributes:
        velocity: vx, vy [m/s], yaw rate [rad/s].
        limits: lowest and highest value of each of them.
        paused: whether time stands still.
    """

    def __init__(self, velocity: Sequence[float], top: float) -> None:
        self.velocity = np.array(velocity, dtype=float)
        self.limits = ((-BACKWARD, top), (-SIDEWAYS, SIDEWAYS), (-TURNING, TURNING))
        self.paused = False
        self._pushes: list[np.ndarray] = []
        self._restart = False
        self._cameras = list(CAMERAS)
        self._camera: str | None = self._cameras[0]

    def change(self, index: int, amount: float) -> None:
        """Add to one part of the command, within its limits."""
        self.set(index, self.velocity[index] + amount)

    def set(self, index: int, value: float) -> None:
        """Set one part of the command, within its limits."""
        self.velocity[index] = np.round(np.clip(value, *self.limits[index]), 3)

    def stop(self) -> None:
        """Command standing still."""
        self.velocity[:] = 0.0

    def toggle_pause(self) -> None:
        """Let time stand still, or go on."""
        self.paused = not self.paused

    def push(self, forward: float, leftward: float) -> None:
        """Ask for a push that changes the base's velocity [m/s]."""
        self._pushes.append(np.array([forward, leftward]))

    def restart(self) -> None:
        """Ask for a new start."""
        self._restart = True

    def next_camera(self) -> None:
        """Ask for the next of the cameras, in turn."""
        self._cameras.append(self._cameras.pop(0))
        self._camera = self._cameras[0]

    def take_camera(self) -> str | None:
        """Camera that was asked for since the last call; the first one at first."""
        camera, self._camera = self._camera, None
        return camera

    def take_push(self) -> np.ndarray | None:
        """Oldest push that was not given yet."""
        return self._pushes.pop(0) if self._pushes else None

    def take_restart(self) -> bool:
        """Whether a new start was asked for since the last call."""
        restart, self._restart = self._restart, False
        return restart
