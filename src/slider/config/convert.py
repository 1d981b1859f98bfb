"""Between plain nested values and typed configuration objects."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import cache
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from slider.core.errors import UserError

T = TypeVar("T")
Place = list[str | int]
Describe = Callable[[Any, Place], Any]
"""Words what a type accepts at a place below it."""


def to_dict(config: Any) -> dict[str, Any]:
    """Plain nested dictionaries of a configuration dataclass."""
    return asdict(config)


def from_dict(cls: type[T], values: Any, key: str = "", describe: Describe | None = None) -> T:
    """A configuration object from plain nested values.

    Args:
        cls: type of the object.
        values: of its fields.
        key: what people call the whole.
        describe: words what was expected; else pydantic does.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    try:
        return _adapter(cls).validate_json(json.dumps(values))
    except ValidationError as error:
        raise UserError(_mistake(cls, error, values, key, describe)) from None


@cache
def _adapter(cls: type[T]) -> TypeAdapter[T]:
    """Types are built when they are first used."""
    return TypeAdapter(cls)


def _mistake(
    cls: type,
    error: ValidationError,
    values: Any,
    key: str,
    describe: Describe | None,
) -> str:
    """One line about the first mistake: key, what was expected and what was found."""
    place, first = _first([(_place(item["loc"], values), item) for item in error.errors()])
    absent = first["type"] == "missing"
    if absent and isinstance(first["loc"][-1], str):  # else a number of a vector
        place = [*place, first["loc"][-1]]
    name = key + "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)
    name = name.lstrip(".") or "configuration"
    if first["type"] == "unexpected_keyword_argument":
        return f"unknown configuration key '{name}'"
    if first["type"] == "rule" or describe is None:
        expected = first["msg"].removeprefix("Input should be ")
    else:
        expected = describe(cls, place)
    value = "none" if absent else json.dumps(first["input"], ensure_ascii=False)
    return f"{name}: expected {expected}, found {value}"


def _first(mistakes: list[tuple[Place, ErrorDetails]]) -> tuple[Place, ErrorDetails]:
    """The first mistake; of a union's types the nearest, whose mistake is deepest."""
    place, _ = mistakes[0]
    below = (item for item in mistakes if item[0][: len(place)] == place)
    return max(below, key=lambda item: len(item[0]))


def _place(location: Sequence[str | int], values: Any) -> Place:
    """The parts of a location that lead somewhere; others are names of types."""
    place: Place = []
    for part in location:
        if part in values if isinstance(values, dict) else _is_index(part, values):
            place.append(part)
            values = values[part]
    return place


def _is_index(part: str | int, values: Any) -> bool:
    return isinstance(part, int) and isinstance(values, list | tuple) and part < len(values)
