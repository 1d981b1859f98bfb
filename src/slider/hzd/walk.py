"""The limit cycle of a gait, its return map, and the foot placement that stabilises it.

A section are the states just after an impact, x = (q, q̇). Outputs are zero or vanish by mid-step
(re-anchoring), so that the return map has the rank of the zero dynamics: (roll, roll rate), with
the hip for a phase also its rate. Their coordinates are ξ = (c_y, ċ_y, ċ_x), lateral position and
horizontal velocity of the centre of mass in the frame of the stance sole; with the clock
ξ = (c_y, ċ_y). Per step ξ⁺ = A ξ + B b, b the displacement of the swing foot.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from slider.config.hzd import HzdConfig
from slider.gait.rooted import NUM
from slider.hzd.feedback import periodic_lqr
from slider.hzd.outputs import YAW, output_matrix
from slider.hzd.plans import motion, start
from slider.hzd.poincare import differences, limit_cycle, restrict
from slider.hzd.step import PHASES, ClosedLoop, Flow, StepPlan

COORDINATES = ("com_y", "com_y_rate", "com_x_rate")
_STATE = 2 * NUM
_REST = np.zeros(2)


@dataclass(frozen=True)
class Walk:
    """A limit cycle of two steps and its linearisation; S phases, r coordinates.

    Attributes:
        points: x* (2, 22) at the sections.
        orbit: ξ* (2, S, 3) at ``PHASES``.
        derivatives: DP (2, 22, 22); ``placements``: ∂P/∂b (2, 22, 2).
        error: greatest change of these with half the difference.
        projection: Z (2, r, 22): ξ of the state on the zero dynamics with the same future.
        maps, inputs: A (2, r, r), B (2, r, 2).
        gains: K (2, 2, r): b = −K ξ.
        phase_gains: K(s) (2, S, 2, 3).
        residuals: of the outputs on the orbit; see ``Flow``.
        pitch: by which the ankle lays the new foot flat, per change of the impact's time
            [rad/s].
    """

    points: np.ndarray
    orbit: np.ndarray
    derivatives: np.ndarray
    placements: np.ndarray
    error: float
    projection: np.ndarray
    maps: np.ndarray
    inputs: np.ndarray
    gains: np.ndarray
    phase_gains: np.ndarray

    @property
    def closed(self) -> np.ndarray:
        """A − B K (2, r, r)."""
        return self.maps - self.inputs @ self.gains

    @property
    def closed_derivatives(self) -> np.ndarray:
        """DP (2, 22, 22) with foot placement."""
        return self.derivatives - self.placements @ self.gains @ self.projection


def linearise(loop: ClosedLoop, steps: Sequence[StepPlan], config: HzdConfig) -> Walk:
    """Limit cycle, return map and foot placement of a gait.

    Raises:
        ValueError: no limit cycle.
        UserError: no foot placement stabilises it.
    """
    settings = config.linearisation
    maps = [lambda x, plan=plan: _observe(loop, plan, x, 0 * x[:, :2])[:, :_STATE] for plan in steps]
    points = limit_cycle(maps, start(steps[0], config), settings.difference, settings.tolerance)
    full = [_derivative(loop, *each, settings.difference) for each in zip(steps, points, strict=True)]
    half = [
        _derivative(loop, *each, settings.difference / 2) for each in zip(steps, points, strict=True)
    ]
    derivative = np.stack(half)
    r = 2 if steps[0].clock else 3
    landed, seen = derivative[:, :_STATE], derivative[:, _STATE:].reshape(2, len(PHASES), 3, -1)
    seen = seen[:, :, :r]
    tangents = [
        _tangent(loop, *each, r) for each in zip(steps, points, seen[:, 0, :, :_STATE], strict=True)
    ]
    free = int(np.searchsorted(PHASES, config.correction_end - 1e-9))
    restriction = restrict(landed[..., :_STATE], tangents, seen[:, free, :, :_STATE])
    projection = restriction.projection
    inputs = projection[::-1] @ landed[..., _STATE:]
    weights = config.feedback
    gains = periodic_lqr(
        restriction.maps,
        inputs,
        np.diag([weights.position, weights.lateral, weights.forward][:r]),
        np.diag(weights.displacement),
    )
    flow = seen[..., :_STATE] @ np.stack(tangents)[:, None]
    flow = flow - seen[..., _STATE:] @ gains[:, None]
    phase_gains = np.zeros((2, len(PHASES), 2, 3))
    phase_gains[..., :r] = gains[:, None] @ np.linalg.inv(flow)
    orbit = np.stack([_seen(loop, loop.step(p, *_split(x))) for p, x in zip(steps, points, strict=True)])
    return Walk(
        np.stack(points),
        orbit[:, 0],
        landed[..., :_STATE],
        landed[..., _STATE:],
        float(np.abs(np.stack(full) - derivative).max()),
        projection,
        restriction.maps,
        inputs,
        gains,
        phase_gains,
    )


def _split(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q and q̇ (n, 11) of a state or of states (n, 22)."""
    x = np.atleast_2d(x)
    return x[:, :NUM], x[:, NUM:]


def _seen(loop: ClosedLoop, flow: Flow) -> np.ndarray:
    """(c_y, ċ_y, ċ_x) at ``PHASES`` (n, S, 3)."""
    found = []
    for q, v in zip(flow.q, flow.v, strict=True):
        at = loop.model.measure(q, v)
        found.append(np.stack([at.com[:, 1], at.com_rate[:, 1], at.com_rate[:, 0]], axis=1))
    return np.stack(found, axis=1)


def _observe(loop: ClosedLoop, plan: StepPlan, x: np.ndarray, b: np.ndarray) -> np.ndarray:
    """State after the next impact (22), then ξ at all phases, of states and displacements."""
    flow = loop.step(plan, *_split(x), b)
    seen = _seen(loop, flow).reshape(len(x), -1)
    return np.concatenate([flow.landed.q, flow.landed.v, seen], axis=1)


def _derivative(loop: ClosedLoop, plan: StepPlan, x: np.ndarray, size: float) -> np.ndarray:
    """Of ``_observe`` by state and displacement (22 + 3 S, 24)."""
    return differences(
        lambda z: _observe(loop, plan, z[:, :_STATE], z[:, _STATE:]), np.r_[x, _REST], size
    )


def _tangent(
    loop: ClosedLoop, plan: StepPlan, point: np.ndarray, seen: np.ndarray, r: int
) -> np.ndarray:
    """E (22, r): states on the zero dynamics at the section, by their ξ.

    Roll and roll rate turn what the outputs leave free; the phase's rate moves along the gait.
    """
    rows = np.delete(output_matrix(loop.config.outputs), YAW, axis=1)
    free = null_space(rows)
    along = motion(plan, np.zeros(1), loop.config)[1].T
    rest = np.zeros((NUM, 1))
    columns = [np.r_[free, rest], np.r_[rest, free], np.r_[rest, along]][:r]
    tangent = np.concatenate(columns, axis=1)
    return tangent @ np.linalg.inv(seen @ tangent)


