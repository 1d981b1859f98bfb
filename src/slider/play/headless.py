"""Nothing to look at: run, then say how it went. For tests and machines without a display."""

import numpy as np

from slider.env.episode import Frame
from slider.play import loop
from slider.play.control import Control
from slider.play.scenes import Scene

_DEFAULT_SECONDS = 10.0


def run(scene: Scene, control: Control, seconds: float | None) -> int:
    """Move as fast as possible; status 1 if the robot fell."""
    frames: list[Frame] = []

    def show(frame: Frame) -> bool:
        frames.append(frame)
        return not frame.failed

    duration = _DEFAULT_SECONDS if seconds is None else seconds
    last = loop.run(scene.motion, control, show, duration, real_time=False)
    half = [frame.velocity[0] for frame in frames[len(frames) // 2 :]]
    fate = f"fell after {last.time:.2f} s" if last.failed else f"up after {last.time:.2f} s"
    print(f"{scene.title}: {fate}, {np.mean(half):.3f} m/s forward in the second half")
    return int(last.failed)
