"""Event-based feedback: the linear-quadratic regulator of a cycle of linear maps.

Once per step, b_j = −K_j ξ_j changes a parameter of the step that ξ_{j+1} = A_j ξ_j + B_j b_j
describes (Westervelt, Grizzle et al., "Feedback Control of Dynamic Bipedal Robot Locomotion", 2007,
section 7.2). Here b displaces the swing foot, with one regulator for each direction. Where these
decoupled regulators do not stabilise a walk, one coupled regulator is used. It is not the first
choice, since it changes the duration of steps in order to correct lateral errors.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag, solve_discrete_are

from slider.config.hzd import FootPlacementConfig
from slider.core.errors import UserError
from slider.hzd.walk import COORDINATES, ZeroDynamics, multipliers

_WEIGHTS = ("position", "velocity", "velocity", "position")  # of the coordinates
_Regulators = tuple[tuple[list[int], list[int]], ...]
# Displacements, forward and leftward, and the coordinates that they feed back.
_DECOUPLED: _Regulators = (([0], [2, 3]), ([1], [0, 1]))
_COUPLED: _Regulators = (([0, 1], [0, 1, 2, 3]),)


@dataclass(frozen=True)
class Regulator:
    """Foot placement of a gait of two steps; S phases, r coordinates.

    Attributes:
        gains: K (2, 2, r): b = −K ξ.
        phase_gains: K(s) (2, S, 2, 4).
        multipliers: moduli per step of the Floquet multipliers, in descending order, without foot
            placement and with it (2, r).
    """

    gains: np.ndarray
    phase_gains: np.ndarray
    multipliers: np.ndarray


def regulate(walk: ZeroDynamics, gait: int, config: FootPlacementConfig) -> Regulator:
    """Foot placement of one of the gaits: decoupled regulators, else a coupled one.

    Raises:
        UserError: no displacement of the foot stabilises the walk.
    """
    reason = ""
    for regulators in (_DECOUPLED, _COUPLED):
        try:
            found = _closed(walk, gait, config, regulators)
        except (np.linalg.LinAlgError, ValueError) as error:
            reason = str(error)
            continue
        greatest = found.multipliers[1, 0]
        if greatest < 1.0:
            return found
        reason = f"a multiplier of {greatest:.3g} with it"
    raise UserError(f"expected a walk that foot placement stabilises, found {reason}")


def _closed(
    walk: ZeroDynamics, gait: int, config: FootPlacementConfig, regulators: _Regulators
) -> Regulator:
    maps, inputs = walk.maps[:, gait], walk.inputs[:, gait]
    by_state, by_input = walk.by_state[:, gait], walk.by_input[:, gait]
    weights = np.array([getattr(config, name) for name in _WEIGHTS])
    (_, phases, r, _), width, steps = by_state.shape, len(COORDINATES), range(2)
    gains, phase_gains = np.zeros((2, 2, r)), np.zeros((2, phases, 2, width))
    for axes, coordinates in regulators:
        answered = [index for index in coordinates if index < r]
        gain = periodic_lqr(
            maps[np.ix_(steps, answered, answered)],
            inputs[np.ix_(steps, answered, axes)],
            np.diag(weights[answered]),
            config.displacement * np.eye(len(axes)),
        )
        gains[np.ix_(steps, axes, answered)] = gain
        flow = by_state[np.ix_(steps, range(phases), answered, answered)]
        flow = flow - by_input[np.ix_(steps, range(phases), answered, axes)] @ gain[:, None]
        at_phase = gain[:, None] @ np.linalg.inv(flow)
        phase_gains[np.ix_(steps, range(phases), axes, answered)] = at_phase
    cycles = maps, maps - inputs @ gains
    moduli = np.sqrt(np.abs([multipliers(each) for each in cycles]))  # a walk has two steps
    return Regulator(gains, phase_gains, moduli)


def periodic_lqr(
    a: np.ndarray, b: np.ndarray, state_weight: np.ndarray, input_weight: np.ndarray
) -> np.ndarray:
    """Gains K (k, m, r) of a cycle of k maps A (k, r, r), B (k, r, m).

    The cycle as one time-invariant system (Bittanti and Colaneri, "Periodic Systems", 2009,
    section 6.3): its state stacks those of all sections, and each map leads to the next.

    Raises:
        LinAlgError, ValueError: no displacement of the foot stabilises the walk.
    """
    period, r, m = b.shape
    shift = np.roll(np.arange(period), 1)
    around = np.kron(np.eye(period)[shift], np.eye(r))
    cycle, inputs = (around @ np.asarray(block_diag(*each)) for each in (a, b))
    weight, effort = np.kron(np.eye(period), state_weight), np.kron(np.eye(period), input_weight)
    cost = solve_discrete_are(cycle, inputs, weight, effort)
    gains = np.linalg.solve(effort + inputs.T @ cost @ inputs, inputs.T @ cost @ cycle)
    return np.stack([gains[m * j : m * (j + 1), r * j : r * (j + 1)] for j in range(period)])
