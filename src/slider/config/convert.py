"""Between plain nested values and typed configuration objects."""

import json
from dataclasses import asdict
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from slider.core.errors import UserError

T = TypeVar("T")


def to_dict(config: Any) -> dict[str, Any]:
    """Plain nested dictionaries of a configuration dataclass."""
    return asdict(config)


def from_dict(cls: type[T], values: Any) -> T:
    """A configuration object from plain nested values.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    try:
        return TypeAdapter(cls).validate_json(json.dumps(values))
    except ValidationError as error:
        raise UserError(_first_mistake(error, values)) from None


def _first_mistake(error: ValidationError, values: Any) -> str:
    """One line: key, what was expected and what was found."""
    first, *others = error.errors()
    place, texts = first["loc"], [first["msg"]]
    missing = first["type"] == "missing"
    if not missing and _is_at(values, place[:-1], first["input"]):  # the last part is a type's name
        place = place[:-1]
        texts += [other["msg"] for other in others if other["loc"][: len(place)] == place]
    key = ".".join(str(part) for part in place)
    expected = " or ".join(dict.fromkeys(texts)).replace(" or Input should be", " or")
    found = "" if missing else f", found {first['input']!r}"
    return f"configuration key '{key}': {expected}{found}"


def _is_at(values: Any, place: tuple[int | str, ...], value: Any) -> bool:
    for part in place:
        if not isinstance(values, dict | list | tuple):
            return False
        values = values[part]  # pyright: ignore[reportArgumentType, reportCallIssue]
    return bool(place) and values == value
