"""Pictures of a walking robot with what it should do and does written on them, as H.264.

Import this module after ``MUJOCO_GL`` is set: MuJoCo picks its renderer when it is imported.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import av
import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from slider.core.config.video import VideoConfig
from slider.env.episode import Frame

_DISTANCE, _AZIMUTH, _ELEVATION = 2.3, 120.0, -12.0  # of the camera [m, degree, degree]
_LOOK_AT_HEIGHT = 0.48  # [m]
_FOLLOW = 0.12  # time constant of the camera behind the base [s]
_INK, _PAPER, _ALARM = (255, 255, 255), (20, 28, 38, 170), (190, 40, 40, 215)


def render(model: mujoco.MjModel, frames: Sequence[Frame], size: tuple[int, int]) -> Iterator:
    """Pictures (height, width, 3) uint8 of a robot, from a camera that follows it.

    Args:
        model: the scene.
        frames: what to show.
        size: width and height [pixel].
    """
    width, height = size
    data, camera = mujoco.MjData(model), _camera()
    position = frames[0].qpos[:2].copy()
    with mujoco.Renderer(model, height, width) as renderer:
        before = frames[0].time
        for frame in frames:
            gain = 1.0 - np.exp(-(frame.time - before) / _FOLLOW)
            position += gain * (frame.qpos[:2] - position)
            before = frame.time
            camera.lookat[:] = [*position, _LOOK_AT_HEIGHT]
            data.qpos[:] = frame.qpos
            mujoco.mj_kinematics(model, data)
            mujoco.mj_camlight(model, data)
            renderer.update_scene(data, camera)
            yield renderer.render()


def _camera() -> mujoco.MjvCamera:
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.distance, camera.azimuth, camera.elevation = _DISTANCE, _AZIMUTH, _ELEVATION
    return camera


def annotate(picture: np.ndarray, title: str, lines: Sequence[str], alarm: bool) -> Image.Image:
    """Write a title and lines onto the upper left corner of a picture."""
    image = Image.fromarray(picture)
    unit = max(8, image.height // 22)
    fonts = [ImageFont.load_default(unit)] * (1 + len(lines))
    draw = ImageDraw.Draw(image, "RGBA")
    texts = [title, *lines]
    width = max(draw.textlength(text, font) for text, font in zip(texts, fonts, strict=True))
    box = (unit // 2, unit // 2, width + 1.5 * unit, (1.35 * len(texts) + 1.1) * unit)
    draw.rounded_rectangle(box, unit // 2, fill=_ALARM if alarm else _PAPER)
    for row, (text, font) in enumerate(zip(texts, fonts, strict=True)):
        draw.text((unit, (0.85 + 1.35 * row) * unit), text, _INK, font)
    return image


def write(pictures: Iterable[Image.Image], config: VideoConfig, path: Path) -> None:
    """Encode pictures as an MP4 file that browsers play; one thread, so same in, same out."""
    with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=Fraction(config.frame_rate))
        stream.width, stream.height, stream.pix_fmt = config.width, config.height, "yuv420p"
        stream.options = {"crf": str(config.quality), "preset": "medium", "threads": "1"}
        for picture in pictures:
            container.mux(stream.encode(av.VideoFrame.from_image(picture)))
        container.mux(stream.encode())
