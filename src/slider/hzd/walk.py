"""The limit cycle of a gait, its return map, and the foot placement that stabilises it.

A section are the states just after an impact, x = (q, q̇). Outputs are zero or vanish by mid-step
(re-anchoring), so that the return map has the rank of the zero dynamics at a section. Their
coordinates are the first r of ξ = (c_y, ċ_y, ċ_x, c_x), place and velocity of the centre of mass
in the frame of the stance sole: r = 3 where the hip's place is the phase; with the clock 4 where
the ankle is free, 2 where it is driven. Per step ξ⁺ = A ξ + B b, b the displacement of the swing
foot. Each direction of b answers its own coordinates: a forward displacement also changes how long
a step takes, and a regulator of both at once times steps in order to catch a lateral error.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import null_space

from slider.config.hzd import StabilityConfig
from slider.gait.rooted import NUM
from slider.hzd.feedback import periodic_lqr
from slider.hzd.outputs import ANKLE, YAW, output_matrix
from slider.hzd.plans import motion, start
from slider.hzd.poincare import Map, differences, limit_cycles, restrict
from slider.hzd.step import PHASES, ClosedLoop, StepPlan

COORDINATES = ("com_y", "com_y_rate", "com_x_rate", "com_x")
_STATE = 2 * NUM
_WEIGHTS = ("position", "velocity", "velocity", "position")  # of the coordinates
_AXES = {0: (2, 3), 1: (0, 1)}  # coordinates that displacements forward and leftward answer


@dataclass(frozen=True)
class Walk:
    """A limit cycle of two steps and its linearisation; S phases, r coordinates.

    Attributes:
        points: x* (2, 22) at the sections.
        orbit: ξ* (2, S, 4) at ``PHASES``.
        derivatives: DP (2, 22, 22); ``placements``: ∂P/∂b (2, 22, 2).
        error: greatest change of these with half the difference.
        projection: Z (2, r, 22): ξ of the state on the zero dynamics with the same future.
        maps, inputs: A (2, r, r), B (2, r, 2).
        gains: K (2, 2, r): b = −K ξ.
        phase_gains: K(s) (2, S, 2, 4).
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


@dataclass(frozen=True)
class Linearisation:
    """Limit cycles of G gaits and derivatives there, before anything is made of them.

    Attributes:
        found: whether there is a limit cycle (G,).
        points: (2, G, 22).
        orbit: (2, G, S, 4).
        derivatives: of state after the next impact and ξ at ``PHASES`` (2, G, 22 + 4 S, 24) by
            state and displacement; ``errors``: their greatest change with half the difference (G,).
    """

    found: np.ndarray
    points: np.ndarray
    orbit: np.ndarray
    derivatives: np.ndarray
    errors: np.ndarray


def linearise(
    loop: ClosedLoop, steps: Sequence[StepPlan], config: StabilityConfig
) -> Linearisation:
    """Limit cycles of n gaits, and their derivatives by central differences."""
    size = config.linearisation.difference
    maps = [partial(_observe, loop, plan) for plan in steps]
    points, found = limit_cycles(
        [partial(_state_after, each) for each in maps],
        start(steps[0], config),
        size,
        config.linearisation.tolerance,
    )
    points = np.where(found[:, None], points, start(steps[0], config))
    at = np.concatenate([points, np.zeros((*points.shape[:2], 2))], axis=2)
    rows = np.arange(len(found))
    orbit = np.stack([each(z, rows)[:, _STATE:] for each, z in zip(maps, at, strict=True)])
    whole, half = (
        np.stack([differences(each, z, share * size) for each, z in zip(maps, at, strict=True)])
        for share in (1.0, 0.5)
    )
    errors = np.abs(whole - half).max(axis=(0, 2, 3))
    orbit = orbit.reshape(2, len(found), len(PHASES), len(COORDINATES))
    return Linearisation(found, points, orbit, half, errors)


def _observe(loop: ClosedLoop, plan: StepPlan, z: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """State after the next impact (22), then ξ at all phases, of states and displacements."""
    flow = loop.step(plan.of(rows), z[:, :_STATE], z[:, _STATE:])
    seen = []
    for q, v in zip(flow.q, flow.v, strict=True):
        at = loop.model.measure(q, v)
        seen += [at.com[:, 1], at.com_rate[:, 1], at.com_rate[:, 0], at.com[:, 0]]
    return np.concatenate([flow.landed.state, np.stack(seen, axis=1)], axis=1)


def _state_after(observe: Map, x: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return observe(np.concatenate([x, np.zeros((len(x), 2))], axis=1), rows)[:, :_STATE]


def walk(
    loop: ClosedLoop,
    steps: Sequence[StepPlan],
    found: Linearisation,
    gait: int,
    config: StabilityConfig,
) -> Walk:
    """Return map and foot placement of one of the gaits.

    Raises:
        UserError: no foot placement stabilises it.
    """
    derivative = found.derivatives[:, gait]
    r = _rank(bool(steps[0].clock[gait]), loop.config)
    landed = derivative[:, :_STATE]
    seen = derivative[:, _STATE:].reshape(2, len(PHASES), len(COORDINATES), -1)[:, :, :r]
    tangents = np.stack(
        [
            _tangent(loop, plan.of(np.array([gait])), now[:, :_STATE])
            for plan, now in zip(steps, seen[:, 0], strict=True)
        ]
    )
    free = int(np.searchsorted(PHASES, config.correction_end - 1e-9))
    restricted = restrict(landed[..., :_STATE], tangents, seen[:, free, :, :_STATE])
    inputs = restricted.projection[::-1] @ landed[..., _STATE:]
    weights = np.array([getattr(config.feedback, name) for name in _WEIGHTS])
    swung, moved = seen[..., :_STATE] @ tangents[:, None], seen[..., _STATE:]
    gains, phase_gains = np.zeros((2, 2, r)), np.zeros((2, len(PHASES), 2, len(COORDINATES)))
    for axis, places in _AXES.items():
        own = [place for place in places if place < r]
        if not own:
            continue
        block = np.ix_(range(2), own, own)
        gain = periodic_lqr(
            restricted.maps[block],
            inputs[:, own, axis : axis + 1],
            np.diag(weights[own]),
            np.array([[config.feedback.displacement]]),
        )
        gains[:, axis, own] = gain[:, 0]
        within = np.ix_(range(2), range(len(PHASES)), own, own)
        flow = swung[within] - moved[:, :, own, axis, None] @ gain[:, None]
        phase_gains[:, :, axis, own] = (gain[:, None] @ np.linalg.inv(flow))[:, :, 0]
    return Walk(
        found.points[:, gait],
        found.orbit[:, gait],
        landed[..., :_STATE],
        landed[..., _STATE:],
        float(found.errors[gait]),
        restricted.projection,
        restricted.maps,
        inputs,
        gains,
        phase_gains,
    )


def _rank(clock: bool, config: StabilityConfig) -> int:
    """Dimension of the zero dynamics at a section."""
    if not clock:
        return 3
    return len(COORDINATES) if config.ankle == "free" else 2


def _tangent(loop: ClosedLoop, plan: StepPlan, seen: np.ndarray) -> np.ndarray:
    """E (22, r): states on the zero dynamics at the section, by their ξ.

    Positions and rates turn what the outputs leave free; the phase's rate moves along the gait.
    """
    outputs = np.delete(output_matrix(loop.config.outputs), YAW, axis=1)
    if len(seen) == len(COORDINATES):
        outputs = np.delete(outputs, ANKLE, axis=0)
    free = null_space(outputs)
    along = motion(plan, np.zeros(1), loop.config)[1].T
    rest = np.zeros_like(free)
    columns = [np.r_[free, rest], np.r_[rest, free], np.r_[0 * along, along]]
    tangent = np.concatenate(columns, axis=1)[:, : len(seen)]
    return tangent @ np.linalg.inv(seen @ tangent)
