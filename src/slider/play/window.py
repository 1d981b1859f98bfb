"""A window with MuJoCo's viewer and keys for commands."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import os
import sys

import mujoco
from mujoco import viewer

from slider.core.errors import UserError
from slider.env.episode import Frame
from slider.play import loop
from slider.play.control import PUSH, Control
from slider.play.scenes import Scene
from slider.robot import names
from slider.robot.scene import aim, build_scene

HELP = """keys: up, down     faster, slower            left, right   turn
      , .          left, right (sideways)    Home          stand
      Enter        push                      Space         pause
      Backspace    start anew                End           next camera
      Esc          close the window"""

DISTANCE = 2.5  # of the camera [m]

# GLFW's numbers of the keys.
_SPACE, _COMMA, _PERIOD, _ENTER, _BACKSPACE, _HOME, _END = 32, 44, 46, 257, 259, 268, 269
_RIGHT, _LEFT, _DOWN, _UP = 262, 263, 264, 265


def on_key(control: Control, key: int) -> None:
    """Do what a key means."""
    changes = {
        _UP: (0, 0.1),
        _DOWN: (0, -0.1),
        _COMMA: (1, 0.05),
        _PERIOD: (1, -0.05),
        _LEFT: (2, 0.1),
        _RIGHT: (2, -0.1),
    }
    if key in changes:
        control.change(*changes[key])
    elif key == _HOME:
        control.stop()
    elif key == _SPACE:
        control.toggle_pause()
    elif key == _ENTER:
        control.push(0.0, PUSH)
    elif key == _BACKSPACE:
        control.restart()
    elif key == _END:
        control.next_camera()


def run(scene: Scene, control: Control, seconds: float | None) -> None:
    """Show the scene until the window is closed.

    Raises:
        UserError: there is no display.
    """
    if sys.platform == "linux" and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise UserError("expected a display, found none: use --web or --headless")
    print(f"{scene.title}\n{HELP}")
    model = build_scene(scene.robot)
    data = mujoco.MjData(model)
    data.qpos[:] = scene.motion.start(control.velocity).qpos
    with viewer.launch_passive(
        model,
        data,
        key_callback=lambda key: on_key(control, key),
        show_left_ui=False,
        show_right_ui=False,
    ) as handle:
        handle.cam.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        handle.cam.trackbodyid = model.body(names.BASE).id

        def show(frame: Frame) -> bool:
            camera = control.take_camera()
            with handle.lock():
                if camera is not None:
                    aim(handle.cam, camera, DISTANCE)
                data.qpos[:] = frame.qpos
                data.time = frame.time
                mujoco.mj_forward(model, data)
            overlay = (None, None, loop.status(frame, control), "")
            handle.set_texts(overlay)
            handle.sync()
            return handle.is_running()

        loop.run(scene.motion, control, show, seconds)
