"""The robot's parameters as a list, found by walking its configuration, and robots that differ."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeGuard

from slider.config.constraint_text import kind_at
from slider.config.convert import from_dict, to_dict
from slider.config.robot import RobotConfig

PROVENANCE = "provenance"


@dataclass(frozen=True)
class Parameter:
    """A number of the robot, or a vector that varies as a whole.

    Attributes:
        path: dotted, below ``robot``.
        value: the numbers, one for a scalar.
        provenance: tag of the longest matching path; empty without one.
        unit: such as ``kg m²``; ``-`` of a share or a factor.
    """

    path: str
    value: tuple[float, ...]
    provenance: str
    unit: str

    @property
    def zero(self) -> bool:
        """Whether no factor changes it."""
        return not any(self.value)


def parameters(robot: RobotConfig) -> list[Parameter]:
    """All numbers and vectors of a robot, in the order of its configuration."""
    values = to_dict(robot)
    tags = values.pop(PROVENANCE)
    return [
        Parameter(path, numbers, tag(tags, path), kind_at(RobotConfig, path.split(".")).unit)
        for path, numbers in _leaves(values)
    ]


def choose(
    found: Sequence[Parameter], tags: Sequence[str], paths: Sequence[str]
) -> list[Parameter]:
    """Parameters with one of the tags, at or below one of the paths if there are any."""
    return [
        item
        for item in found
        if item.provenance in tags and (not paths or any(_within(item.path, p) for p in paths))
    ]


def tag(tags: Mapping[str, str], path: str) -> str:
    """Tag of the longest path that is ``path`` or a group around it; empty without one."""
    matching = [name for name in tags if _within(path, name)]
    return tags[max(matching, key=len)] if matching else ""


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


def _leaves(node: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, tuple[float, ...]]]:
    for name, value in node.items():
        path = f"{prefix}{name}"
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{path}.")
        elif isinstance(value, (list, tuple)) and value and all(map(_is_number, value)):
            yield path, tuple(float(item) for item in value)
        elif _is_number(value):
            yield path, (float(value),)


def _is_number(value: Any) -> TypeGuard[float]:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
