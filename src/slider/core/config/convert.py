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
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        found = "" if first["type"] == "missing" else f", found {first['input']!r}"
        raise UserError(f"configuration key '{key}': {first['msg']}{found}") from None
