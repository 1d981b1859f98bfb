"""Termination terms: pure functions of a state, True where a robot has failed."""

import math
from collections.abc import Mapping
from typing import Annotated

import numpy as np
from pydantic import Field

from slider.config.convert import from_dict
from slider.config.types import Metres, NonNegative, Number, Positive, Radians
from slider.core.arrays import Array
from slider.env.declaration import Function, Needs, Term, check_names, register
from slider.env.state import RobotState

TERMS: dict[str, Term] = {}


def termination(function: Function) -> Function:
    """Declare a termination term: a function of a state and one parameter, (N,) bool."""
    return register(TERMS, Term(function, Needs.NOTHING))


@termination
def base_height(state: RobotState, minimum: NonNegative[Metres]) -> Array:
    """Base less than ``minimum`` above the ground."""
    return state.base_height < minimum


@termination
def tilt(state: RobotState, maximum: Annotated[Positive[Radians], Field(le=math.pi)]) -> Array:
    """Base tilted by more than ``maximum``."""
    return -state.gravity[:, 2] < float(np.cos(maximum))


@termination
def body_contact(state: RobotState, maximum: NonNegative[Number]) -> Array:
    """More than ``maximum`` contacts of a body other than a foot with the ground."""
    return state.body_contacts > maximum


def check(terms: Mapping[str, float]) -> None:
    """Refuse unknown names and impossible parameters.

    Raises:
        UserError: names the key.
    """
    key = "env.termination.terms"
    check_names(TERMS, terms, key)
    for name, value in terms.items():
        (parameter,) = TERMS[name].parameters.values()
        from_dict(parameter, value, f"{key}.{name}")


def failed(state: RobotState, terms: Mapping[str, float]) -> Array:
    """Robots (N,) that failed by any of the terms, or whose simulation blew up."""
    result = state.diverged
    for name, parameter in terms.items():
        result = result | TERMS[name].function(state, parameter)
    return result
