"""One step of the closed loop: the rooted robot under its virtual constraints, up to the impact.

**Outputs.** There are ten outputs y = H (x − x_d(s)). The stance ankle applies the gait's own
effort, however the robot moves, since the short foot allows little more: nine outputs are enforced,
by input-output linearisation with ÿ = −k_p y − k_d ẏ. Their accelerations H' q̈, H' the columns of H
for roll and joints, the ankle's row of M q̈ + h = B u and the roll's, which has no input, are eleven
equations for q̈. The zero dynamics are those of the roll and of the forward motion.

**Phase.** With the clock, s = t/T. With the hip, s = σ(p(q)), outputs and phase are not
independent: p(q) = p*(s) by definition of s, and p(X(s)) = p*(s) for the gait. Where nine outputs
are zero the tenth is too. s̈ = (∇p q̈ + p̈|₀ − p″ ṡ²)/p′ depends on q̈, and so do its terms in ÿ.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.integrate import DOP853

from slider.config.hzd import StabilityConfig
from slider.gait.outputs import ANKLE, JOINTS, NUM_COORDINATES, ROLL, YAW, output_matrix
from slider.gait.rooted import NUM
from slider.hzd.constraints import StepConstraints, phase_of, phase_rate
from slider.hzd.model import Kinematics, PostImpactState, RootedModel
from slider.hzd.plans import StepPlan

PHASES = np.linspace(0.0, 1.0, 21)
"""Phases at which a step is sampled."""

_NODES = np.arange(53) / 40  # of the integration; piecewise polynomials are joined at some of them
_WITHIN = 41  # nodes up to phase 1; by the last of ``_NODES`` a swing foot must be down
_MIN_IMPACT_PHASE = 0.5  # phase from which a swing foot can land
_STAGES = DOP853.n_stages
_A, _B, _C = DOP853.A[:_STAGES, :_STAGES], DOP853.B, DOP853.C[:_STAGES]
_NEWTON = 6
_LOST = 1e9  # greater than any entry of the equations of a robot that walks
_SLOWEST = 0.05  # share of the gait's phase rate: a robot whose hip moves backward has fallen


@dataclass(frozen=True)
class Flow:
    """Trajectories of n steps.

    Attributes:
        q, v: at ``PHASES`` (S, n, 11).
        after_impact: states just after the impacts.
        phase, time: of the impacts (n,) [-], [s].
        alive: (n,) whether the swing foot came down.
    """

    q: np.ndarray
    v: np.ndarray
    after_impact: PostImpactState
    phase: np.ndarray
    time: np.ndarray
    alive: np.ndarray


@dataclass(frozen=True)
class ClosedLoop:
    """The robot under virtual constraints."""

    model: RootedModel
    config: StabilityConfig

    @cached_property
    def outputs(self) -> np.ndarray:
        """H (10, 12)."""
        return output_matrix(self.model.geometry)

    @cached_property
    def columns(self) -> np.ndarray:
        """Columns of H for the roll and the joints (10, 11)."""
        return np.delete(self.outputs, YAW, axis=1)

    def step(
        self,
        plan: StepPlan,
        x: np.ndarray,
        displacement: np.ndarray | None = None,
    ) -> Flow:
        """Simulate from n states x = (q, q̇) (n, 22) just after an impact to just after the next.

        The swing foot is displaced by ``displacement`` (n, 2) [m].
        """
        constraints = plan.constraints(self.config)
        if displacement is not None:
            constraints.displacement = displacement
        steps = _Steps(self, plan, constraints)
        with np.errstate(invalid="ignore", over="ignore"):
            return steps.flow(np.pad(x, ((0, 0), (0, 1))))

    def part(self, plan: StepPlan, x: np.ndarray, place: int) -> tuple[np.ndarray, np.ndarray]:
        """q and v (n, 11) at ``PHASES[place]`` of steps from n states just after an impact."""
        steps = _Steps(self, plan, plan.constraints(self.config))
        with np.errstate(invalid="ignore", over="ignore"):
            z = steps.part(np.pad(x, ((0, 0), (0, 1))), place)
        return z[:, :NUM], z[:, NUM:-1]


@dataclass(frozen=True)
class _Steps:
    """n robots during one step; states z (n, 23) are q, v and time as functions of the phase."""

    loop: ClosedLoop
    plan: StepPlan
    constraints: StepConstraints

    def flow(self, z: np.ndarray) -> Flow:
        phase = self._start(z)
        nodes, heights = [self._advance(phase, z, -phase)], [np.zeros(len(z))]
        for s, after in pairwise(_NODES):
            nodes.append(self._to_node(s, nodes[-1], after))
            heights.append(self._measure(nodes[-1]).height)
            if after > 1.0 and not (heights[-1] > 0).any():
                break
        phase, z, alive = self._impact(np.stack(nodes), np.stack(heights))
        q, v = z[:, :NUM], z[:, NUM:-1]
        sampled = np.stack(nodes[:_WITHIN:2])
        return Flow(
            sampled[..., :NUM],
            sampled[..., NUM:-1],
            self.loop.model.impact_map(q, v),
            phase,
            z[:, -1],
            alive,
        )

    def part(self, z: np.ndarray, place: int) -> np.ndarray:
        """States (n, 23) at one of ``PHASES``."""
        phase = self._start(z)
        z = self._advance(phase, z, -phase)
        for s, after in pairwise(_NODES[: 2 * place + 1]):
            z = self._to_node(s, z, after)
        return z

    def _start(self, z: np.ndarray) -> np.ndarray:
        """Phases (n,) just after the impact; re-anchors the constraints."""
        phase = np.where(self.plan.clock, 0.0, phase_of(self.plan.hip, self._measure(z).hip))
        x, rate = _coordinates(z)
        self.constraints.re_anchor(phase, x, rate / self._rate(phase, z)[:, None])
        return phase

    def _measure(self, z: np.ndarray) -> Kinematics:
        return self.loop.model.measure(z[:, :NUM], z[:, NUM:-1])

    def _rate(self, phase: np.ndarray, z: np.ndarray) -> np.ndarray:
        """ṡ (n,) [1/s]."""
        hip = phase_rate(self.plan.hip, phase, self._measure(z).hip_rate)
        return np.where(self.plan.clock, 1.0 / self.plan.duration, hip)

    def _derivative(self, phase: np.ndarray, z: np.ndarray) -> np.ndarray:
        """dz/ds (n, 23)."""
        config = self.loop.config
        q, v = z[:, :NUM], z[:, NUM:-1]
        rows, bias, slope, bend = self.loop.model.constrained(q, v)
        nominal, hip = 1.0 / self.plan.duration, ~self.plan.clock
        _, hip_slope, hip_bend = (order[:, 0] for order in self.plan.hip.at(phase))
        rate = np.where(hip, (slope * v).sum(axis=1) / hip_slope, nominal)
        rate = np.where(rate > _SLOWEST * nominal, rate, np.nan)
        turn = np.where(hip, (bend - hip_bend * rate**2) / hip_slope, 0.0)  # s̈ at q̈ = 0
        desired, first, second = self.constraints.desired(phase)
        x, x_rate = _coordinates(z)
        error, error_rate = x - desired, x_rate - first * rate[:, None]
        driven = second * (rate**2)[:, None] + first * turn[:, None]
        driven -= config.kp * error + config.kd * error_rate
        matrix = np.empty((len(z), NUM, NUM))
        right = np.empty((len(z), NUM))
        matrix[:, :-1], right[:, :-1] = self.loop.columns, driven @ self.loop.outputs.T
        if hip.any():
            share = (first @ self.loop.outputs.T)[:, :, None] * slope[:, None]
            share /= hip_slope[:, None, None]
            share[~hip] = 0.0
            matrix[:, :-1] -= share
        matrix[:, ANKLE] = rows[:, 1]
        right[:, ANKLE] = self.plan.ankle.at(phase)[0][:, 0] - bias[:, 1]
        matrix[:, -1], right[:, -1] = rows[:, 0], -bias[:, 0]
        lost = ~(np.abs(matrix).max(axis=(1, 2)) < _LOST)
        matrix[lost], right[lost] = np.eye(NUM), np.nan
        acceleration = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
        derivative = np.concatenate([v, acceleration, np.ones((len(z), 1))], axis=1)
        return derivative / rate[:, None]

    def _advance(self, phase: np.ndarray, z: np.ndarray, width: np.ndarray) -> np.ndarray:
        """One step of the Runge-Kutta method of order 8 of Dormand and Prince."""
        slopes = np.zeros((_STAGES, *z.shape))
        for k in range(_STAGES):
            inner = np.tensordot(_A[k, :k], slopes[:k], axes=1) if k else 0.0
            slopes[k] = self._derivative(phase + _C[k] * width, z + width[:, None] * inner)
        return z + width[:, None] * np.tensordot(_B, slopes, axes=1)

    def _to_node(self, phase: float, z: np.ndarray, after: float) -> np.ndarray:
        """Advance from one node to the next."""
        return self._advance(np.full(len(z), phase), z, np.full(len(z), after - phase))

    def _impact(
        self, nodes: np.ndarray, heights: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Phases (n,) and states (n, 23) at touchdown of the swing foot; whether there is one."""
        late = _NODES[: len(nodes) - 1, None] >= _MIN_IMPACT_PHASE
        down = (heights[:-1] > 0) & (heights[1:] <= 0) & late
        alive = np.asarray(down.any(axis=0))
        last, rows = np.where(alive, down.argmax(axis=0), 0), np.arange(nodes.shape[1])
        start, before = _NODES[last], nodes[last, rows]
        high, low = heights[last, rows], heights[last + 1, rows]
        most = _NODES[last + 1] - start
        width = most * np.where(alive, high / np.where(alive, high - low, 1.0), 0.0)
        for _ in range(_NEWTON):
            z = self._advance(start, before, width)
            measured = self._measure(z)
            moved = width - measured.height / measured.height_rate * self._rate(start + width, z)
            width = np.where(alive & (np.abs(moved) <= 2 * most), moved, 0.5 * most)
        return start + width, self._advance(start, before, width), alive


def _coordinates(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x and ẋ (n, 12)."""
    coordinates = np.zeros((2, len(z), NUM_COORDINATES))
    for part, values in zip(coordinates, (z[:, :NUM], z[:, NUM:-1]), strict=True):
        part[:, ROLL], part[:, JOINTS:] = values[:, 0], values[:, 1:]
    return coordinates[0], coordinates[1]
