"""Common rules: each raises a ``UserError`` with key, expectation and finding."""

import json
import re
from collections.abc import Iterable
from typing import Any

from slider.core.errors import UserError

NAME = re.compile(r"[a-z][a-z0-9_]*")
"""Of what is a target, a file or a row: it reads the same to a shell, on any disk, in a table."""


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


def named(key: str, names: Iterable[str]) -> None:
    """Each a name that nobody must quote."""
    expected = "names of small letters, digits and _ after a letter"
    for name in names:
        require(NAME.fullmatch(name) is not None, key, expected, json.dumps(name))
