"""Common rules: each raises a ``UserError`` with key, expectation and finding."""

from collections.abc import Iterable
from typing import Any

from slider.core.errors import UserError


def require(condition: bool, key: str, expected: str, found: Any) -> None:
    """Any condition; the others are common ones."""
    if not condition:
        raise UserError(f"{key}: expected {expected}, found {found}")


def period(key: str, start: float, end: float, step: float) -> None:
    """From ``start`` there is at least a ``step`` before ``end`` [s]."""
    require(start <= end - step + 1e-9, key, f"a time in [0, {end - step:g}] s", start)


def ordered(key: str, lower: float, upper: float) -> None:
    """lower ≤ upper."""
    require(lower <= upper, key, "lower ≤ upper", f"{lower} > {upper}")


def multiple(key: str, value: float, step: float) -> None:
    """A whole number of ``step``."""
    steps = value / step
    require(abs(steps - round(steps)) < 1e-6, key, f"a multiple of {step:g}", value)


def one_of(key: str, value: Any, allowed: Iterable[Any]) -> None:
    """A member of ``allowed``."""
    options = tuple(allowed)
    require(value in options, key, f"one of {', '.join(map(str, options))}", value)


def distinct(key: str, values: list[Any], expected: str) -> None:
    """No value twice."""
    require(len(set(values)) == len(values), key, expected, values)
