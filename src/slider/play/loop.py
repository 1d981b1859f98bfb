"""A user's control of a motion, the loop in real time, and the headless loop."""

import time
from collections.abc import Callable, Sequence

import numpy as np

from slider.env.rollout import Frame, mean_speed
from slider.play.scenes import Motion, Scene
from slider.robot.scene import CAMERAS

BACKWARD, SIDEWAYS, TURNING = 1.0, 0.5, 1.0
"""Highest backward and sideways speed [m/s] and yaw rate [rad/s]."""
PUSH = 0.4
"""Change of the base's velocity [m/s]."""
_SECONDS = 10.0  # headless

Show = Callable[[Frame], bool]
"""Shows a frame; returns whether to go on."""


class Control:
    """Velocity, pause, camera, and requests; written by one thread, read by another.

    ``velocity`` is vx, vy [m/s], yaw rate [rad/s], each within its ``limits``; ``top`` is the
    highest speed [m/s].
    """

    def __init__(self, velocity: Sequence[float], top: float) -> None:
        self.velocity = np.array(velocity, dtype=float)
        self.limits = (-BACKWARD, top), (-SIDEWAYS, SIDEWAYS), (-TURNING, TURNING)
        self.paused = False
        self._pushes: list[np.ndarray] = []
        self._restart = False
        self._cameras = list(CAMERAS)
        self._camera: str | None = self._cameras[0]

    def change(self, index: int, amount: float) -> None:
        """Add to one part of the velocity, within its limits."""
        self.set(index, self.velocity[index] + amount)

    def set(self, index: int, value: float) -> None:
        """Set one part of the velocity, within its limits."""
        self.velocity[index] = np.round(np.clip(value, *self.limits[index]), 3)

    def stop(self) -> None:
        """Command standing still."""
        self.velocity[:] = 0.0

    def toggle_pause(self) -> None:
        """Pause or resume."""
        self.paused = not self.paused

    def push(self, forward: float, leftward: float) -> None:
        """Request a push that changes the base's velocity [m/s]."""
        self._pushes.append(np.array([forward, leftward]))

    def restart(self) -> None:
        """Request a new start."""
        self._restart = True

    def next_camera(self) -> None:
        """Request the next of the cameras, in turn."""
        self._cameras.append(self._cameras.pop(0))
        self._camera = self._cameras[0]

    def take_camera(self) -> str | None:
        """Camera requested since the last call; at first the first one."""
        camera, self._camera = self._camera, None
        return camera

    def take_push(self) -> np.ndarray | None:
        """Oldest requested push, removed from the queue."""
        return self._pushes.pop(0) if self._pushes else None

    def take_restart(self) -> bool:
        """Whether a new start was requested since the last call."""
        restart, self._restart = self._restart, False
        return restart


def run(
    motion: Motion,
    control: Control,
    show: Show,
    seconds: float | None = None,
    real_time: bool = True,
) -> Frame:
    """Move until ``show`` returns false or the time [s] is over; return the last frame."""
    frame, elapsed = motion.start(control.velocity), 0.0
    while show(frame) and (seconds is None or elapsed < seconds - 1e-9):
        began = time.monotonic()
        if control.take_restart():
            frame = motion.start(control.velocity)
        elif not control.paused:
            push = control.take_push()
            if push is not None:
                motion.push(push)
            frame = motion.step(control.velocity)
        elapsed += motion.period
        if real_time:
            time.sleep(max(0.0, motion.period - (time.monotonic() - began)))
    return frame


def record(motion: Motion, control: Control, seconds: float) -> list[Frame]:
    """Frames of ``seconds`` [s], simulated as fast as possible; a fall ends them."""
    frames: list[Frame] = []

    def keep(frame: Frame) -> bool:
        frames.append(frame)
        return not frame.failed

    run(motion, control, keep, seconds, real_time=False)
    return frames


def status(frame: Frame, control: Control) -> str:
    """Commanded and actual velocity in one line."""
    vx, vy, yaw = control.velocity
    state = "fallen" if frame.failed else "paused" if control.paused else "walking"
    return (
        f"{state}, t = {frame.time:5.1f} s, commanded {vx:+.2f} {vy:+.2f} m/s {yaw:+.2f} rad/s, "
        f"actual {frame.velocity[0]:+.2f} {frame.velocity[1]:+.2f} m/s"
    )


def run_headless(scene: Scene, control: Control, seconds: float | None) -> int:
    """Move as fast as possible and print the outcome; return 1 if the robot fell."""
    frames = record(scene.motion, control, _SECONDS if seconds is None else seconds)
    last = frames[-1]
    fate = f"{'fell' if last.failed else 'up'} after {last.time:.2f} s"
    print(f"{scene.title}: {fate}, {mean_speed(frames):.3f} m/s forward in the second half")
    return int(last.failed)
