"""A motion as an animation that repeats without a jump, or that ends in a fall."""

from pathlib import Path

import numpy as np
from PIL import Image

from slider.core.errors import require
from slider.env.rollout import Frame
from slider.play import loop
from slider.play.scenes import Scene
from slider.reports import film

_WARM_UP = 4.0  # from rest to a periodic walk [s]
_WALK = 1.0  # longer than a walk of two steps: the loop ends in the last of these [s]
_SECONDS = 3.8
_FRAME_RATE = 25  # [1/s]
_SIZE = (480, 320)  # [pixel]
_QUALITY = 60


def run(scene: Scene, control: loop.Control, seconds: float | None, path: Path) -> int:
    """Write the steady part of a motion, from the side, as an animated WebP; 1 if the robot fell.

    Of a fall it shows everything from the start.

    Raises:
        UserError: the motion is shorter than a walk, nothing can be rendered on this machine, or
            the name is not that of a WebP.
    """
    require(path.suffix.lower() == ".webp", "--film", "a name that ends with .webp", path)
    length = _SECONDS if seconds is None else seconds
    require(length >= _WALK, "--film", f"--seconds of at least {_WALK:g}", f"{length:g}")
    frames = loop.record(scene.motion, control, _WARM_UP + length)
    fell, every = frames[-1].failed, round(1.0 / (_FRAME_RATE * scene.motion.period))
    if fell:
        shown, first = frames[::-every][::-1], 0
        end = len(shown)
    else:
        shown, first = frames[::every], round(_WARM_UP * _FRAME_RATE)
        end = first + repeats_at(shown[first:])
    # The camera follows with a lag: it moves as the robot does only after a while.
    seen, terrain = shown[first // 2 : end], scene.motion.terrain
    ground = None if terrain is None else film.relief(terrain.ground, seen)
    rendered = list(film.render(scene.robot, seen, _SIZE, ("side",), ground))
    pictures = [Image.fromarray(picture) for picture in rendered[first - first // 2 :]]
    path.parent.mkdir(parents=True, exist_ok=True)
    pictures[0].save(
        path,
        save_all=True,
        append_images=pictures[1:],
        duration=1000 // _FRAME_RATE,
        loop=0,
        quality=_QUALITY,
        method=4,
    )
    print(f"{path}: {scene.title} fell after {frames[-1].time:.2f} s" if fell else path)
    return int(fell)


def repeats_at(frames: list[Frame]) -> int:
    """Index of the frame whose pose is nearest to the first one's, among those of the last walk."""
    poses = np.array([frame.qpos[2:] for frame in frames])
    first = max(1, len(frames) - round(_WALK * _FRAME_RATE))
    return first + int(np.argmin(np.linalg.norm(poses[first:] - poses[0], axis=1)))
