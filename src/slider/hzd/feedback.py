"""Event-based feedback: the linear-quadratic regulator of a cycle of linear maps.

Once per step, b_j = −K_j ξ_j changes a parameter of the step that ξ_{j+1} = A_j ξ_j + B_j b_j
describes (Westervelt, Grizzle et al., "Feedback Control of Dynamic Bipedal Robot Locomotion", 2007,
section 7.2).
"""

import numpy as np
from scipy.linalg import block_diag, solve_discrete_are

from slider.core.errors import UserError


def periodic_lqr(
    a: np.ndarray, b: np.ndarray, state_weight: np.ndarray, input_weight: np.ndarray
) -> np.ndarray:
    """Gains K (k, m, r) of a cycle of k maps A (k, r, r), B (k, r, m).

    The cycle as one time-invariant system (Bittanti and Colaneri, "Periodic Systems", 2009,
    section 6.3): the states of all sections side by side, each map leading to the next place.

    Raises:
        UserError: no displacement of the foot stabilises the walk.
    """
    period, r, m = b.shape
    shift = np.roll(np.arange(period), 1)
    around = np.kron(np.eye(period)[shift], np.eye(r))
    whole, inputs = (around @ np.asarray(block_diag(*each)) for each in (a, b))
    weight, effort = np.kron(np.eye(period), state_weight), np.kron(np.eye(period), input_weight)
    try:
        cost = solve_discrete_are(whole, inputs, weight, effort)
    except np.linalg.LinAlgError as error:
        raise UserError(f"expected a walk that foot placement stabilises, found {error}") from None
    gains = np.linalg.solve(effort + inputs.T @ cost @ inputs, inputs.T @ cost @ whole)
    return np.stack([gains[m * j : m * (j + 1), r * j : r * (j + 1)] for j in range(period)])
