"""Numerical parameters of a robot by dotted path and tag, and robots with one of them scaled."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from slider.config.convert import from_dict, to_dict, with_settings
from slider.config.robot import RobotConfig
from slider.core.files import flatten


class Parameter(NamedTuple):
    """A numerical parameter of the robot: a scalar, or a vector that is scaled as one."""

    path: str  # dotted, below ``robot``
    value: tuple[float, ...]  # of length 1 for a scalar
    provenance: str  # tag of the longest matching path; empty without one


def parameters(robot: RobotConfig) -> list[Parameter]:
    """All numbers and vectors of a robot, in the order of its configuration."""
    values = to_dict(robot)
    tags = values.pop("provenance")
    no_sizes = "order", "direction"
    return [
        Parameter(path, tuple(map(float, np.atleast_1d(value))), tag(tags, path))
        for path, value in flatten(values).items()
        if isinstance(value, float | tuple) and not path.endswith(no_sizes)
    ]


def choose(
    items: Sequence[Parameter], tags: Sequence[str], paths: Sequence[str]
) -> list[Parameter]:
    """Parameters with one of the tags, and, if ``paths`` are given, at or below one of them."""
    tagged = [item for item in items if item.provenance in tags]
    return [item for item in tagged if not paths or any(_within(item.path, p) for p in paths)]


def tag(tags: Mapping[str, str | None], path: str) -> str:
    """Tag of the longest path that is ``path`` or a parent of it; empty without one."""
    matching = [name for name in tags if _within(path, name)]
    return tags[max(matching, key=len)] or "" if matching else ""


def _within(path: str, group: str) -> bool:
    return f"{path}.".startswith(f"{group}.")


def scaled(robot: RobotConfig, path: str, factor: float) -> RobotConfig:
    """The robot with one parameter multiplied by ``factor``.

    Raises:
        UserError: there is no such robot.
    """
    values = to_dict(robot)
    value = flatten(values)[path]
    # Rounded to 12 digits, so that 60 · 1.2 is 72.
    products = [float(f"{number * factor:.12g}") for number in np.atleast_1d(value).tolist()]
    product = products if isinstance(value, tuple) else products[0]
    return from_dict(RobotConfig, with_settings(values, {path: product}), "robot")
