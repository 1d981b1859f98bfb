"""Conversion between plain nested values and typed configuration objects."""

import copy
import json
import re
from collections.abc import Mapping
from dataclasses import asdict
from functools import cache, reduce
from operator import getitem
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from slider.core.errors import UserError
from slider.core.files import flatten

T = TypeVar("T")
_LONGEST = 100  # characters of a value in a message
# Removed from pydantic's messages: "List should have at least 1 item after validation, not 0".
_FRAME = re.compile(r"^\w+ should (be|have) |^Value error, |( after validation)?, not \d+$")


def to_dict(config: Any) -> dict[str, Any]:
    """Plain nested dictionaries of a configuration dataclass."""
    return asdict(config)


def from_dict(cls: type[T], values: Any, key: str = "") -> T:
    """A configuration object from plain nested values; ``key`` is its dotted name.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    try:
        return _adapter(cls).validate_json(json.dumps(values), context=values)
    except ValidationError as error:
        raise UserError(_mistake(error, values, key)) from None


def setting(values: Mapping[str, Any], name: str) -> float | None:
    """The number at a dotted name of nested values, None without one."""
    value = flatten(values).get(name)
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return value if number else None


def with_settings(values: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Nested values with some replaced, by existing dotted names."""
    changed = copy.deepcopy(dict(values))
    for name, value in settings.items():
        *groups, last = name.split(".")
        reduce(getitem, groups, changed)[last] = value
    return changed


@cache
def _adapter(cls: type[T]) -> TypeAdapter[T]:
    """Adapter of a type, built at the first use."""
    return TypeAdapter(cls)


def _mistake(error: ValidationError, values: Any, key: str) -> str:
    """One line about the first mistake: key, what was expected and what was found.

    Each type of a union has an error: the one of the best matching type is the deepest.
    """
    items = [(_place(item["loc"], values), item) for item in error.errors()]
    first, _ = items[0]
    items = [item for item in items if item[0][: len(first)] == first]
    place, chosen = max(items, key=lambda item: len(item[0]))
    messages = [item["msg"] for other, item in items if other == place]
    expected = " or ".join(dict.fromkeys(_FRAME.sub("", message) for message in messages))
    expected = expected.replace("an object", "keys and values").replace("a valid array", "a list")
    value, context = chosen["input"], chosen.get("ctx", {})
    if names := context.get("names"):
        value = {name: value[name] for name in names if name in value}
    found = json.dumps(value, ensure_ascii=False)
    found = found if len(found) <= _LONGEST else f"{found[: _LONGEST - 1]}…"
    if "name" in context:
        found, place = context.get("found", found), [*place, *filter(None, [context["name"]])]
    elif chosen["type"] == "missing":
        expected, found = "a value", "none"
        place += chosen["loc"][-1:]
    elif "discriminator" in context:
        place.append(name := context["discriminator"].strip("'"))
        expected = context.get("expected_tags", "a value").replace(", ", " or ")
        found = json.dumps(value[name], ensure_ascii=False) if name in value else "none"
    name = key + "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)
    name = name.lstrip(".") or "configuration"
    if chosen["type"] == "unexpected_keyword_argument":
        return f"unknown configuration key '{name}'"
    return f"{name}: expected {expected}, found {found}"


def _place(location: tuple[str | int, ...], values: Any) -> list[str | int]:
    """Parts of pydantic's location that are keys or indices of ``values``; others name types."""
    place: list[str | int] = []
    for part in location:
        try:
            values = values[part]
        except (KeyError, IndexError, TypeError):
            continue
        place.append(part)
    return place
