"""What every term says of itself: types of its parameters, and what it needs."""

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Flag, auto
from typing import Any, TypeVar

from slider.core.arrays import Array
from slider.core.errors import UserError


class Needs(Flag):
    """What a term reads that not every training has or keeps.

    The clock's phase, gaits of the library, the outputs of the control step before.
    """

    NOTHING = 0
    CLOCK = auto()
    LIBRARY = auto()
    HISTORY = auto()


@dataclass(frozen=True)
class Term:
    """A pure function, by whose name the configuration calls the term.

    Attributes:
        function: of what it looks at, and of its parameters; an array with a row per robot.
        needs: without which it is worth nothing.
    """

    function: Callable[..., Array]
    needs: Needs

    @property
    def parameters(self) -> dict[str, Any]:
        """Types of its parameters in order, with their units and bounds."""
        found = inspect.get_annotations(self.function)
        return {name: found[name] for name in list(inspect.signature(self.function).parameters)[1:]}


AnyTerm = TypeVar("AnyTerm", bound=Term)
Function = TypeVar("Function", bound=Callable[..., Array])


def register(
    terms: dict[str, AnyTerm], make: Callable[[Function], AnyTerm]
) -> Callable[[Function], Function]:
    """A decorator that adds the term of a function to ``terms``, and leaves the function as it is.

    It raises a ValueError at a name that is taken.
    """

    def add(function: Function) -> Function:
        name, term = function.__name__, make(function)
        if name in terms:
            raise ValueError(f"expected a new name for a term, found {name} again")
        terms[name] = term
        return function

    return add


def check_names(terms: Mapping[str, Term], names: Iterable[str], key: str) -> None:
    """Refuse a name of no term with a ``UserError`` that names the key."""
    for name in names:
        if name not in terms:
            raise UserError(f"{key}: expected some of {', '.join(terms)}; found {name}")
