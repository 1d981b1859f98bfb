"""H.264 films of a walking robot, with its command and its motion written on the pictures.

Import this module after ``MUJOCO_GL`` is set: MuJoCo picks its renderer when it is imported.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import os
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import av
import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from slider.config.evaluation import VideoConfig
from slider.config.robot import RobotConfig, leg_scale
from slider.core.errors import UserError
from slider.env.height_field import Ground
from slider.env.rollout import Frame
from slider.robot.scene import Relief, aim, build_scene

_DISTANCE = 2.15  # of the camera from SLIDER [m]
_BELOW = 0.25  # of the camera's target below the base of SLIDER [m]
_AROUND = 4.0  # ground that is drawn on all sides of the path [m]
_CELL = 0.02  # of that ground [m]
_FOLLOW = 0.12  # time constant of the camera behind the base [s]
_INK, _PAPER, _ALARM = (255, 255, 255), (20, 28, 38, 170), (190, 40, 40, 215)


def relief(ground: Ground, frames: Sequence[Frame]) -> Relief:
    """The ground (of one robot) around the path that the robot takes in ``frames``."""
    way = np.array([frame.qpos[:2] for frame in frames])
    (left, back), (right, front) = way.min(axis=0) - _AROUND, way.max(axis=0) + _AROUND
    x, y = np.arange(left, right, _CELL), np.arange(back, front, _CELL)
    heights = ground.height(np.stack(np.meshgrid(x, y), axis=-1)[None])[0]
    return Relief(heights, (left, x[-1]), (back, y[-1]))


def render(
    robot: RobotConfig,
    frames: Sequence[Frame],
    size: tuple[int, int],
    cameras: Sequence[str],
    relief: Relief | None = None,
) -> Iterator[np.ndarray]:
    """Pictures (height, width, 3) uint8 of a robot; ``size`` is width and height [pixel].

    The views of the ``cameras`` of ``CAMERAS``, which follow it, are side by side. A ``relief``
    replaces the flat floor.

    Raises:
        UserError: nothing can be rendered on this machine.
    """
    width, height = size
    model = build_scene(robot, width, height, relief)
    data, views, scale = mujoco.MjData(model), [], leg_scale(robot.geometry.leg_length)
    for name in cameras:
        views.append(mujoco.MjvCamera())
        views[-1].type = mujoco.mjtCamera.mjCAMERA_FREE
        aim(views[-1], name, _DISTANCE * scale)
    position, before = frames[0].qpos[:3].copy(), frames[0].time
    try:
        with mujoco.Renderer(model, height, width // len(views)) as renderer:
            for frame in frames:
                gain = 1.0 - np.exp(-(frame.time - before) / _FOLLOW)
                position += gain * (frame.qpos[[0, 1, 2]] - position)
                before = frame.time
                data.qpos[:] = frame.qpos
                mujoco.mj_kinematics(model, data)
                mujoco.mj_camlight(model, data)
                pictures = []
                for view in views:
                    view.lookat[:] = position - [0.0, 0.0, _BELOW * scale]
                    renderer.update_scene(data, view)
                    pictures.append(renderer.render())
                yield np.hstack(pictures)
    except (ImportError, RuntimeError, AttributeError, mujoco.FatalError) as error:  # bad OpenGL
        raise UserError(
            f"expected to render with {os.environ.get('MUJOCO_GL', 'a display')}, found: {error}; "
            "MUJOCO_GL=osmesa may work, and report.video.renderer=none makes a page without videos"
        ) from None


def annotate(picture: np.ndarray, title: str, subtitle: str, alarm: bool) -> Image.Image:
    """Write title and subtitle onto the lower left corner of a picture, on the floor."""
    image = Image.fromarray(picture)
    unit = max(8, image.height // 22)
    font, text = ImageFont.load_default(unit), f"{title}\n{subtitle}"
    draw = ImageDraw.Draw(image, "RGBA")
    _, _, right, bottom = draw.textbbox((unit, 0), text, font, spacing=unit // 2)
    top = image.height - bottom - 1.2 * unit
    box = (unit // 2, top, right + unit // 2, image.height - unit // 2)
    draw.rounded_rectangle(box, unit // 2, fill=_ALARM if alarm else _PAPER)
    draw.text((unit, top + 0.2 * unit), text, _INK, font, spacing=unit // 2)
    return image


def write(pictures: Iterable[Image.Image], config: VideoConfig, path: Path) -> None:
    """Encode pictures as an MP4 file that browsers play; one thread, so that it is reproducible."""
    with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=Fraction(config.frame_rate))
        stream.width, stream.height, stream.pix_fmt = config.width, config.height, "yuv420p"
        stream.options = {"crf": str(config.quality), "preset": "medium", "threads": "1"}
        for picture in pictures:
            container.mux(stream.encode(av.VideoFrame.from_image(picture)))
        container.mux(stream.encode())
