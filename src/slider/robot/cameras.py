"""From where people look at the robot, in films and in the viewer."""

from typing import Any, NamedTuple


class Direction(NamedTuple):
    """Of a view: turn about the vertical axis from +x, slope (negative: down) [degree]."""

    azimuth: float
    elevation: float


CAMERAS = {
    "side": Direction(110.0, -10.0),  # from the right, slightly from behind: the floor shows depth
    "front": Direction(180.0, -10.0),
}


def aim(camera: Any, name: str, distance: float) -> None:
    """Let a camera of MuJoCo's look at its target from a distance [m], as ``CAMERAS`` says."""
    camera.azimuth, camera.elevation = CAMERAS[name]
    camera.distance = distance
