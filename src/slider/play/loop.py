"""The loop that moves the robot in real time and shows it."""

import math
import time
from collections.abc import Callable

from slider.env.episode import Frame
from slider.play.control import Control
from slider.play.motion import Motion

Show = Callable[[Frame], bool]
"""Shows a frame; tells whether to go on."""


def run(
    motion: Motion,
    control: Control,
    show: Show,
    seconds: float | None = None,
    real_time: bool = True,
) -> Frame:
    """Move until ``show`` says stop or the time [s] is over; return the last frame."""
    frame = motion.start(control.velocity)
    limit = math.inf if seconds is None else seconds
    elapsed = 0.0
    while show(frame) and elapsed < limit - 1e-9:
        began = time.monotonic()
        frame = advance(motion, control, frame)
        elapsed += motion.period
        if real_time:
            time.sleep(max(0.0, motion.period - (time.monotonic() - began)))
    return frame


def advance(motion: Motion, control: Control, frame: Frame) -> Frame:
    """One control period, with what the person asked for."""
    if control.take_restart():
        return motion.start(control.velocity)
    if control.paused:
        return frame
    push = control.take_push()
    if push is not None:
        motion.push(push)
    return motion.step(control.velocity)


def status(frame: Frame, control: Control) -> str:
    """What is commanded and what is done, in one line."""
    vx, vy, yaw = control.velocity
    state = "fallen" if frame.failed else "paused" if control.paused else "walking"
    return (
        f"{state}, t = {frame.time:5.1f} s, command {vx:+.2f} {vy:+.2f} m/s {yaw:+.2f} rad/s, "
        f"actual {frame.velocity[0]:+.2f} {frame.velocity[1]:+.2f} m/s"
    )
