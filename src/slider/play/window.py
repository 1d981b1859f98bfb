"""A window with MuJoCo's viewer and keys for the velocity."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import sys
import warnings
from collections.abc import Callable

import glfw
import mujoco
from mujoco import viewer

from slider.config.robot import leg_scale
from slider.core.errors import UserError
from slider.env.rollout import Frame
from slider.play import loop
from slider.play.loop import PUSH, Control
from slider.play.scenes import Scene
from slider.robot import names
from slider.robot.scene import aim, build_scene

_HELP = """keys: up, down     faster, slower            left, right   turn
      , .          left, right (sideways)    Home          stand
      Enter        push                      Space         pause
      Backspace    restart                   End           next camera
      Esc          close the window"""

_DISTANCE = 2.5  # of the camera from SLIDER [m]

_CHANGES = {
    glfw.KEY_UP: (0, 0.1),
    glfw.KEY_DOWN: (0, -0.1),
    glfw.KEY_COMMA: (1, 0.05),
    glfw.KEY_PERIOD: (1, -0.05),
    glfw.KEY_LEFT: (2, 0.1),
    glfw.KEY_RIGHT: (2, -0.1),
}
_ACTIONS: dict[int, Callable[[Control], None]] = {
    glfw.KEY_HOME: Control.stop,
    glfw.KEY_SPACE: Control.toggle_pause,
    glfw.KEY_ENTER: lambda control: control.push(0.0, PUSH),
    glfw.KEY_BACKSPACE: Control.restart,
    glfw.KEY_END: Control.next_camera,
}


class NoWindow(UserError):
    """There is no display, or no window can be opened on it."""


def on_key(control: Control, key: int) -> None:
    """Do the action of a key."""
    if key in _CHANGES:
        control.change(*_CHANGES[key])
    elif key in _ACTIONS:
        _ACTIONS[key](control)


def run(scene: Scene, control: Control, seconds: float | None) -> None:
    """Show the scene until the window is closed.

    Raises:
        NoWindow: there is no display, or no window can be opened on it.
    """
    if sys.platform == "linux":
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # GLFW's own text about the display
            if not glfw.init():
                raise NoWindow("expected a display, found none")
    print(f"{scene.title}\n{_HELP}")
    model = build_scene(scene.robot)
    data = mujoco.MjData(model)
    data.qpos[:] = scene.motion.start(control.velocity).qpos
    try:
        window = viewer.launch_passive(
            model,
            data,
            key_callback=lambda key: on_key(control, key),
            show_left_ui=False,
            show_right_ui=False,
        )
    except (RuntimeError, mujoco.FatalError) as error:  # no window, or macOS without mjpython
        raise NoWindow(f"expected a window, found: {error}") from None
    distance = _DISTANCE * leg_scale(scene.robot.geometry.leg_length)
    with window as handle:
        handle.cam.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        handle.cam.trackbodyid = model.body(names.BASE).id

        def show(frame: Frame) -> bool:
            camera = control.take_camera()
            with handle.lock():
                if camera is not None:
                    aim(handle.cam, camera, distance)
                data.qpos[:] = frame.qpos
                data.time = frame.time
                mujoco.mj_forward(model, data)
            handle.set_texts((None, None, loop.status(frame, control), ""))
            handle.sync()
            return handle.is_running()

        loop.run(scene.motion, control, show, seconds)
