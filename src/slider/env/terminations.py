"""Termination terms: pure functions of a state, True where a robot has failed."""

import math
from collections.abc import Callable, Mapping

import numpy as np

from slider.env.declaration import Function, Needs, Parameter, Term, check_names, register
from slider.env.state import RobotState

TERMS: dict[str, Term] = {}


def termination(**parameter: Parameter) -> Callable[[Function], Function]:
    """Declare a termination term: a function of a state and one parameter, (N,) bool."""
    return register(TERMS, lambda function: Term(function, Needs.NOTHING, parameter))


@termination(minimum=Parameter("m"))
def base_height(state: RobotState, minimum: float) -> np.ndarray:
    """Base less than ``minimum`` above the ground."""
    return state.base_height < minimum


@termination(maximum=Parameter("rad", above=0, most=math.pi))
def tilt(state: RobotState, maximum: float) -> np.ndarray:
    """Base tilted by more than ``maximum``."""
    return -state.gravity[:, 2] < np.cos(maximum)


@termination(maximum=Parameter("-", least=0))
def body_contact(state: RobotState, maximum: float) -> np.ndarray:
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
        parameter.check(f"{key}.{name}", value)


def failed(state: RobotState, terms: Mapping[str, float]) -> np.ndarray:
    """Robots (N,) that failed by any of the terms, or whose simulation blew up."""
    result = state.diverged.copy()
    for name, parameter in terms.items():
        result |= TERMS[name].function(state, parameter)
    return result
