"""Types of configuration values: bounds, units and rules that can be combined.

The schema combines them, ``t.Positive[t.Metres]``, and each field has a docstring. Upper bounds are
generous: they reject what cannot be a length, time or count, such as 1e30.
"""

import json
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import reduce
from itertools import pairwise
from typing import Annotated, Any, Generic, TypeVar, dataclass_transform

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationInfo,
)
from pydantic.dataclasses import dataclass as checked_dataclass
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

_STRICT = ConfigDict(
    extra="forbid",
    strict=True,
    allow_inf_nan=False,
    defer_build=True,  # a job needs the validators of only a few of a hundred classes
)

SAME = 1e-6
"""Numbers of a list count as equal up to this difference."""

T = TypeVar("T")


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
class Group:
    """Base class of groups of values: subclasses are frozen dataclasses that check their values.

    Unknown keys, wrong types, infinity and NaN are rejected. A rule about several values of a group
    is a :func:`require` in its ``__post_init__``.
    """

    def __init_subclass__(cls, kw_only: bool = False) -> None:
        super().__init_subclass__()
        checked_dataclass(cls, frozen=True, kw_only=kw_only, config=_STRICT)


def Unit(text: str) -> Any:
    """Unit of a number; ``rad | m``: for revolute joints, and for the slide."""
    return Field(json_schema_extra={"unit": text})


@dataclass(frozen=True)
class Rule:
    """Further condition on a value: description, test, and ``names`` of a group it compares."""

    text: str
    holds: Callable[[Any], object]
    names: tuple[str, ...] = ()

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.with_info_after_validator_function(self.checked, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return handler(schema) | {"rule": self.text}

    def checked(self, value: Any, info: ValidationInfo) -> Any:
        """The value, if the rule holds; ``info.context`` is the whole configuration."""
        if not self.holds(value):
            raise PydanticCustomError("rule", "{text}", {"text": self.text, "names": self.names})
        return value


class Multiple(Rule):
    """Integer multiple of a step that is given at a dotted name of the complete configuration.

    Not checked in the section of a job, which lacks that name: its values have been checked.
    """

    def __init__(self, step: str) -> None:
        super().__init__(f"a multiple of {step}", bool, tuple(step.split(".")))

    def checked(self, value: Any, info: ValidationInfo) -> Any:
        """The value, if it is a multiple."""
        try:
            step: Any = reduce(lambda node, name: node[name], self.names, info.context or {})
            steps = value / step
        except (KeyError, TypeError, ZeroDivisionError):
            return value
        require(abs(steps - round(steps)) < 1e-6, "", f"a multiple of {step:g}", value)
        return value


def require(condition: object, name: str, expected: str, found: object = None) -> None:
    """Reject a group unless a condition holds for the value at a dotted name below it.

    The message shows ``found`` instead of the whole group.
    """
    if not condition:
        own = {} if found is None else {"found": str(found)}
        raise PydanticCustomError("rule", "{expected}", {"expected": expected, "name": name, **own})


def complete(name: str, names: Iterable[str], expected: Iterable[str]) -> None:
    """Reject a group whose value ``name`` does not have exactly the expected keys, in any order."""
    names, expected = tuple(names), tuple(expected)
    require(set(names) == set(expected), name, ", ".join(expected), ", ".join(names))


def ordered(*names: str, strict: bool = False) -> Rule:
    """Rule that attributes of a group do not decrease, or, if ``strict``, increase."""

    def holds(group: Any) -> bool:
        pairs = pairwise(getattr(group, name) for name in names)
        return all(a < b or (a == b and not strict) for a, b in pairs)

    return Rule((" < " if strict else " ≤ ").join(names), holds, names)


def _distinct(values: list[Any]) -> bool:
    pairs = pairwise(sorted(values))
    return all(a != b if isinstance(a, str) else b - a > SAME for a, b in pairs)


NAME = re.compile(r"[a-z][a-z0-9_]*")
"""Name of a target, file or row that is valid in shells, file systems and tables."""


def _named(items: dict[str, Any]) -> dict[str, Any]:
    for name in items:
        expected = "names of small letters, digits and _ after a letter"
        require(NAME.fullmatch(name), "", expected, json.dumps(name))
    return items


Named = Annotated[dict[str, T], AfterValidator(_named)]
Positive = Annotated[T, Field(gt=0)]
NonNegative = Annotated[T, Field(ge=0)]
Even = Annotated[T, Rule("an even number", lambda value: value % 2 == 0)]
Odd = Annotated[T, Rule("an odd number", lambda value: value % 2 == 1)]
Some = Annotated[list[T], Field(min_length=1)]
Distinct = Annotated[T, Rule("each once", _distinct)]
Rising = Annotated[T, Rule("rising values", lambda values: sorted({*values}) == values)]
Falling = Annotated[T, Rule("falling values", lambda values: sorted({*values})[::-1] == values)]
Vector3 = tuple[T, T, T]

Name = Annotated[str, Field(min_length=1)]
Count = Annotated[int, Field(ge=1, le=1_000_000)]
Seed = Annotated[int, Field(ge=0, le=2**63 - 1)]

Number = Annotated[float, Unit("-"), Field(ge=-1e9, le=1e9)]
Factor = Annotated[float, Unit("-"), Field(ge=0, le=1e3)]
Share = Annotated[float, Unit("-"), Field(ge=0, le=1)]
Tolerance = Annotated[float, Unit("-"), Field(gt=0, le=1)]

Seconds = Annotated[float, Unit("s"), Field(ge=0, le=1e5)]
Metres = Annotated[float, Unit("m"), Field(ge=-1e3, le=1e3)]
MetresPerSecond = Annotated[float, Unit("m/s"), Field(ge=-100, le=100)]
SecondsPerMetre = Annotated[float, Unit("s/m"), Field(ge=0, le=1000)]
MetresPerSecond2 = Annotated[float, Unit("m/s²"), Field(ge=0, le=1e4)]
Radians = Annotated[float, Unit("rad"), Field(ge=-100, le=100)]
RadiansPerSecond = Annotated[float, Unit("rad/s"), Field(ge=-1e4, le=1e4)]
Kilograms = Annotated[float, Unit("kg"), Field(ge=0, le=1e4)]
KilogramMetres2 = Annotated[float, Unit("kg m²"), Field(ge=0, le=1e4)]
Newtons = Annotated[float, Unit("N"), Field(ge=0, le=1e6)]
NewtonSeconds = Annotated[float, Unit("N s"), Field(ge=0, le=1e4)]
NewtonMetres = Annotated[float, Unit("N m"), Field(ge=0, le=1e6)]
JointPosition = Annotated[float, Unit("rad | m"), Field(ge=-100, le=100)]


class Interval(Group, Generic[T]):
    """Closed interval."""

    lower: T
    """lower bound"""
    upper: T
    """upper bound"""

    def __post_init__(self) -> None:
        require(self.lower <= self.upper, "", "lower ≤ upper")  # pyright: ignore[reportOperatorIssue]
