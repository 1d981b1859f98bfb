"""Declaration of terms: their function, the types of its parameters, and what it needs."""

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Flag, auto
from typing import Any, TypeVar

from slider.core.arrays import Array
from slider.core.errors import UserError


class Needs(Flag):
    """What a term reads that not every training has.

    ``CLOCK``: phase; ``LIBRARY``: gaits.
    """

    NOTHING = 0
    CLOCK = auto()
    LIBRARY = auto()


@dataclass(frozen=True)
class Term:
    """A pure function; the configuration lists the term by the function's name.

    Attributes:
        function: maps a view or state and parameters to an array with a row per robot.
        needs: what it reads.
    """

    function: Callable[..., Array]
    needs: Needs

    @property
    def parameters(self) -> dict[str, Any]:
        """Types of its parameters in order, with their units and bounds."""
        hints = list(inspect.get_annotations(self.function).items())
        return dict(hints[1:-1])  # without view and result


AnyTerm = TypeVar("AnyTerm", bound=Term)
Function = Callable[..., Array]


def register(terms: dict[str, AnyTerm], term: AnyTerm) -> Function:
    """Add a term to ``terms`` under the name of its function; return the function.

    Raises:
        ValueError: the name is taken.
    """
    name = term.function.__name__
    if name in terms:
        raise ValueError(f"expected a new name for a term, found {name} again")
    terms[name] = term
    return term.function


def check_names(terms: Mapping[str, Term], names: Iterable[str], key: str) -> None:
    """Raise a ``UserError`` that names the key if a name is not that of a term."""
    for name in names:
        if name not in terms:
            raise UserError(f"{key}: expected some of {', '.join(terms)}; found {name}")
