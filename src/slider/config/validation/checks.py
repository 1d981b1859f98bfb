"""Checks of single values: each raises a ``UserError`` with key, expectation and finding."""

import math
from collections.abc import Iterable, Sized
from dataclasses import fields, is_dataclass
from operator import attrgetter
from typing import Any

from slider.config.interval import Interval
from slider.core.errors import UserError


def require(condition: bool, key: str, expected: str, found: Any) -> None:
    """Any condition; the others are common ones."""
    if not condition:
        raise UserError(f"{key}: expected {expected}, found {found}")


def at_least(key: str, value: float, least: float) -> None:
    """value ≥ least."""
    require(value >= least, key, f"a value ≥ {least}", value)


def positive(key: str, value: float) -> None:
    """value > 0."""
    require(value > 0, key, "a positive value", value)


def fraction(key: str, value: float) -> None:
    """0 ≤ value ≤ 1."""
    require(0 <= value <= 1, key, "a share in [0, 1]", value)


def period(key: str, start: float, end: float, step: float) -> None:
    """From ``start`` there is at least a ``step`` before ``end`` [s]."""
    require(0 <= start <= end - step + 1e-9, key, f"a time in [0, {end - step:g}] s", start)


def share(key: str, value: float) -> None:
    """0 < value ≤ 1."""
    require(0 < value <= 1, key, "a share in (0, 1]", value)


def all_at_least(key: str, node: Any, names: Iterable[str], least: float) -> None:
    """Several attributes of ``node``, whose key is ``key``; ``names`` may have dots."""
    for name in names:
        at_least(f"{key}.{name}", attrgetter(name)(node), least)


def all_positive(key: str, node: Any, names: Iterable[str]) -> None:
    """Several attributes of ``node``, whose key is ``key``; ``names`` may have dots."""
    for name in names:
        positive(f"{key}.{name}", attrgetter(name)(node))


def ordered(key: str, lower: float, upper: float) -> None:
    """lower ≤ upper."""
    require(lower <= upper, key, "lower ≤ upper", f"{lower} > {upper}")


def interval(key: str, value: Interval) -> None:
    """An interval that is not empty."""
    ordered(key, value.lower, value.upper)


def multiple(key: str, value: float, step: float) -> None:
    """A whole number of ``step``."""
    steps = value / step
    require(abs(steps - round(steps)) < 1e-6, key, f"a multiple of {step:g}", value)


def one_of(key: str, value: Any, allowed: Iterable[Any]) -> None:
    """A member of ``allowed``."""
    options = tuple(allowed)
    require(value in options, key, f"one of {', '.join(map(str, options))}", value)


def some(key: str, values: Sized, what: str) -> None:
    """Not empty; ``what`` is the noun for one of the values."""
    require(len(values) > 0, key, f"at least one {what}", "none")


def distinct(key: str, values: list[Any], expected: str) -> None:
    """No value twice."""
    require(len(set(values)) == len(values), key, expected, values)


def finite(key: str, node: Any) -> None:
    """No infinite number and no NaN, however deep."""
    if isinstance(node, float):
        require(math.isfinite(node), key, "a finite number", node)
    for name, value in _children(key, node):
        finite(name, value)


def _children(key: str, node: Any) -> list[tuple[str, Any]]:
    if is_dataclass(node):
        names = [item.name for item in fields(node)]
        return [(f"{key}.{name}".lstrip("."), getattr(node, name)) for name in names]
    if isinstance(node, dict):
        return [(f"{key}.{name}", value) for name, value in node.items()]
    if isinstance(node, (list, tuple)):
        return [(f"{key}[{index}]", value) for index, value in enumerate(node)]
    return []
