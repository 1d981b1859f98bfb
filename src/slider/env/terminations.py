"""Termination terms: pure functions of a state, True where a robot has failed."""

from collections.abc import Callable, Mapping

import numpy as np

from slider.core.errors import UserError
from slider.env.state import RobotState


def base_height(state: RobotState, minimum: float) -> np.ndarray:
    """Base less than ``minimum`` [m] above the ground."""
    return state.base_height < minimum


def tilt(state: RobotState, maximum: float) -> np.ndarray:
    """Base tilted by more than ``maximum`` [rad]."""
    return -state.gravity[:, 2] < np.cos(maximum)


def body_contact(state: RobotState, maximum: float) -> np.ndarray:
    """More than ``maximum`` contacts of a body other than a foot with the ground."""
    return state.body_contacts > maximum


TERMS: dict[str, Callable[[RobotState, float], np.ndarray]] = {
    "base_height": base_height,
    "tilt": tilt,
    "body_contact": body_contact,
}


def check(terms: Mapping[str, float]) -> None:
    """Refuse unknown names.

    Raises:
        UserError: a term that does not exist.
    """
    for name in terms:
        if name not in TERMS:
            raise UserError(
                f"env.termination.terms: expected some of {', '.join(TERMS)}; found {name}"
            )


def failed(state: RobotState, terms: Mapping[str, float]) -> np.ndarray:
    """Robots (N,) that failed by any of the terms, or whose simulation blew up."""
    result = state.diverged.copy()
    for name, parameter in terms.items():
        result |= TERMS[name](state, parameter)
    return result
