"""The numbers of the robot as a list, and robots that differ in one of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from slider.config.convert import from_dict, to_dict
from slider.config.robot import RobotConfig
from slider.core.files import flatten


@dataclass(frozen=True)
class Parameter:
    """A number of the robot, or a vector that varies as a whole.

    Attributes:
        path: dotted, below ``robot``.
        value: the numbers, one for a scalar.
        provenance: tag of the longest matching path; empty without one.
    """

    path: str
    value: tuple[float, ...]
    provenance: str


def parameters(robot: RobotConfig) -> list[Parameter]:
    """All numbers and vectors of a robot, in the order of its configuration."""
    values = to_dict(robot)
    tags = values.pop("provenance")
    numbers = {
        path: tuple(map(float, value)) if isinstance(value, tuple) else (value,)
        for path, value in flatten(values).items()
        if isinstance(value, float | tuple)
    }
    return [Parameter(path, value, tag(tags, path)) for path, value in numbers.items()]


def choose(
    items: Sequence[Parameter], tags: Sequence[str], paths: Sequence[str]
) -> list[Parameter]:
    """Parameters with one of the tags, at or below one of the paths if there are any."""
    return [
        item
        for item in items
        if item.provenance in tags and (not paths or any(_within(item.path, p) for p in paths))
    ]


def tag(tags: Mapping[str, str | None], path: str) -> str:
    """Tag of the longest path that is ``path`` or a group around it; empty without one."""
    matching = [name for name in tags if _within(path, name)]
    return tags[max(matching, key=len)] or "" if matching else ""


def scaled(robot: RobotConfig, path: str, factor: float) -> RobotConfig:
    """The robot with one parameter multiplied by ``factor``; it may be an impossible one.

    Raises:
        UserError: the parameter takes no such value.
    """
    values = to_dict(robot)
    *groups, name = path.split(".")
    node: Any = values
    for group in groups:
        node = node[group]
    node[name] = _times(node[name], factor)
    return from_dict(RobotConfig, values, "robot")


def _within(path: str, group: str) -> bool:
    return f"{path}.".startswith(f"{group}.")


def _times(value: Any, factor: float) -> Any:
    """Products without the last digits, so that 60 · 1.2 is 72."""
    if isinstance(value, (list, tuple)):
        return [_times(item, factor) for item in value]
    return float(f"{value * factor:.12g}")
