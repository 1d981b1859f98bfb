"""A motion as an animation, or several as tiles."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image

from slider.core.errors import require
from slider.env.rollout import Frame
from slider.play import loop
from slider.play.scenes import Scene
from slider.reports import film

_WARM_UP = 4.0  # from rest to a periodic walk [s]
_SECONDS = 3.8
_FRAME_RATE = 25  # [1/s]
_SIZE = (640, 320)  # [pixel]
_QUALITY = 60
_TILE = (320, 240)  # [pixel]
_COLUMNS = 3  # of tiles
_PUSHED = 1.0  # after the film's beginning [s]


class Tile(NamedTuple):
    """What one tile of a film shows: a speed [m/s], the ground, a push (2,) [m/s]."""

    title: str
    speed: float
    kind: str = "flat"
    level: float = 0.0
    push: tuple[float, float] | None = None
    camera: str = "side"


TILES = (
    Tile("flat ground", 0.4),
    Tile("flat ground", 1.2),
    Tile("flat ground", 3.0),
    Tile("push of 0.6 m/s to the left", 1.2, push=(0.0, 0.6), camera="front"),
    Tile("slope of 7.5°", 0.8, "slope_up", 6.0),
    Tile("stairs of 4 cm", 0.6, "stairs_up", 4.0),
)
_TERRAIN = "evaluation.disturbance.terrain"


def run(scene: Scene, control: loop.Control, seconds: float | None, path: Path) -> int:
    """Write a motion's steady part, from side and front, as an animated WebP; 1 if the robot fell.

    If the robot fell, the film shows everything from the start.

    Raises:
        UserError: nothing can be rendered on this machine, or the name is not that of a WebP.
    """
    require(path.suffix.lower() == ".webp", "--film", "a name that ends with .webp", path)
    length = _SECONDS if seconds is None else seconds
    every = _every(scene)
    frames = loop.record(scene.motion, control, _WARM_UP + length)
    fell = frames[-1].failed
    shown = frames[::-every][::-1] if fell else frames[::every]
    first = 0 if fell else round(_WARM_UP * _FRAME_RATE)
    # The camera follows with a lag: it moves as the robot does only after a while.
    rendered = _render(scene, shown[first // 2 :], _SIZE, ("side", "front"))
    _write([Image.fromarray(picture) for picture in rendered[first - first // 2 :]], path)
    print(f"{path}: {scene.title} fell after {frames[-1].time:.2f} s" if fell else path)
    return int(fell)


def run_tiles(choose: Callable[[list[str]], Scene], seconds: float | None, path: Path) -> int:
    """Write ``TILES`` of scenes that ``choose`` builds from overrides; return 1 if a robot fell."""
    require(path.suffix.lower() == ".webp", "--film", "a name that ends with .webp", path)
    length, fallen, columns = seconds or _SECONDS, False, []
    for tile in TILES:
        level = f"{{lower: {tile.level}, upper: {tile.level}}}"
        scene = choose([f"{_TERRAIN}.kinds=[{tile.kind}]", f"{_TERRAIN}.level={level}"])
        tile = tile._replace(speed=min(tile.speed, scene.top))
        frames = _walk(scene, tile, _WARM_UP + length)
        every = _every(scene)
        # The camera follows with a lag: it begins to move a second before.
        shown = frames[round((_WARM_UP - 1.0) / scene.motion.period) :: every]
        rendered = _render(scene, shown, _TILE, (tile.camera,))
        parts = zip(rendered, _subtitle(tile, shown), shown, strict=True)
        pictures = [
            film.annotate(seen, tile.title, subtitle, at.failed) for seen, subtitle, at in parts
        ]
        columns.append(pictures[_FRAME_RATE:])
        fallen |= frames[-1].failed
    pictures = []
    for moment in zip(*columns, strict=True):
        rows = (moment[first : first + _COLUMNS] for first in range(0, len(TILES), _COLUMNS))
        pictures.append(Image.fromarray(np.vstack([np.hstack(row) for row in rows])))
    _write(pictures, path)
    print(f"{path}: a robot fell" if fallen else path)
    return int(fallen)


def _every(scene: Scene) -> int:
    """Control periods per picture."""
    periods = 1.0 / (_FRAME_RATE * scene.motion.period)
    whole = round(periods) >= 1 and math.isclose(periods, round(periods))
    expected = f"{1 / _FRAME_RATE:g} s divided by a whole number, for a film"
    require(whole, "env.control_period", expected, f"{scene.motion.period:g}")
    return round(periods)


def _render(
    scene: Scene, frames: list[Frame], size: tuple[int, int], cameras: Sequence[str]
) -> list[np.ndarray]:
    """Pictures of a scene's robot on its ground."""
    terrain = scene.motion.terrain
    ground = None if terrain is None else film.relief(terrain.ground, frames)
    return list(film.render(scene.robot, frames, size, cameras, ground))


def _walk(scene: Scene, tile: Tile, seconds: float) -> list[Frame]:
    """Frames of one robot from rest, pushed once where the tile says so; it lies where it fell."""
    control, frames = loop.Control((tile.speed, 0.0, 0.0), scene.top), []
    moment = round((_WARM_UP + _PUSHED) / scene.motion.period)

    def show(frame: Frame) -> bool:
        frames.append(frame)
        if tile.push is not None and len(frames) == moment:
            control.push(*tile.push)
        return not frame.failed

    loop.run(scene.motion, control, show, seconds, real_time=False)
    return frames + [frames[-1]] * (round(seconds / scene.motion.period) + 1 - len(frames))


def _subtitle(tile: Tile, frames: list[Frame]) -> list[str]:
    """Commanded speed, and the mean of the last second, at each of the frames."""
    speeds = np.cumsum([frame.velocity[0] for frame in frames])
    speeds[_FRAME_RATE:] -= speeds[:-_FRAME_RATE].copy()
    means = speeds / np.minimum(np.arange(len(frames)) + 1, _FRAME_RATE)
    return [f"command {tile.speed:.2f} m/s   measured {mean:z.2f} m/s" for mean in means]


def _write(pictures: Sequence[Image.Image], path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    options: dict[str, Any] = {"duration": 1000 // _FRAME_RATE, "quality": _QUALITY, "method": 4}
    pictures[0].save(path, save_all=True, append_images=pictures[1:], loop=0, **options)
