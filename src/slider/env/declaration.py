"""What every term says of itself: its parameters with units and bounds, what it needs."""

import inspect
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Flag, auto
from typing import TypeVar

import numpy as np

from slider.core.errors import UserError


class Needs(Flag):
    """What a term reads that not every training has: the clock's phase, gaits of the library."""

    NOTHING = 0
    CLOCK = auto()
    LIBRARY = auto()


@dataclass(frozen=True)
class Parameter:
    """A number that a term takes: its unit ("-" for none) and its bounds."""

    unit: str = "-"
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf

    def check(self, key: str, value: float) -> None:
        """Refuse a value out of the bounds with a ``UserError`` that names the key."""
        if not (self.above < value and self.least <= value <= self.most):
            signs = {">": self.above, "≥": self.least, "≤": self.most}
            bounds = " and ".join(f"{s} {b:g}" for s, b in signs.items() if math.isfinite(b))
            raise UserError(f"{key}: expected a value {bounds} [{self.unit}], found {value}")


@dataclass(frozen=True)
class Term:
    """A pure function, by whose name the configuration calls the term.

    Attributes:
        function: of what it looks at, and of its parameters; an array with a row per robot.
        needs: without which it is worth nothing.
        declared: units and bounds of its parameters, where they have any.
    """

    function: Callable[..., np.ndarray]
    needs: Needs
    declared: Mapping[str, Parameter]

    @property
    def parameters(self) -> dict[str, Parameter]:
        """All that it takes, in order."""
        names = list(inspect.signature(self.function).parameters)[1:]
        return {name: self.declared.get(name, Parameter()) for name in names}


AnyTerm = TypeVar("AnyTerm", bound=Term)
Function = TypeVar("Function", bound=Callable[..., np.ndarray])


def register(
    terms: dict[str, AnyTerm], make: Callable[[Function], AnyTerm]
) -> Callable[[Function], Function]:
    """A decorator that adds the term of a function to ``terms``, and leaves the function as it is.

    It raises a ValueError at a name that is taken, and at a declared parameter that is not there.
    """

    def add(function: Function) -> Function:
        name, term = function.__name__, make(function)
        if name in terms:
            raise ValueError(f"expected a new name for a term, found {name} again")
        if not set(term.declared) <= set(term.parameters):
            found = list(term.declared)
            raise ValueError(f"{name}: expected some of {list(term.parameters)}, found {found}")
        terms[name] = term
        return function

    return add


def check_names(terms: Mapping[str, Term], names: Iterable[str], key: str) -> None:
    """Refuse a name of no term with a ``UserError`` that names the key."""
    for name in names:
        if name not in terms:
            raise UserError(f"{key}: expected some of {', '.join(terms)}; found {name}")
