"""Reward terms: pure functions of a view and the guide, each (N,), named in the configuration."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field

from slider.config.convert import from_dict
from slider.config.train import RewardConfig, RewardTerm
from slider.config.types import (
    Metres,
    MetresPerSecond,
    Newtons,
    NonNegative,
    Number,
    Positive,
    Radians,
    RadiansPerSecond,
    Share,
    Unit,
)
from slider.core.arrays import Array, namespace
from slider.core.errors import UserError
from slider.env.declaration import Function, Needs, Term, check_names, register
from slider.env.observations import target_angular_velocity, target_linear_velocity
from slider.env.phase import standing
from slider.env.state import View
from slider.robot.kinematics import turn_to_heading
from slider.robot.names import GAIT_JOINTS, NUM_CHANNELS, NUM_JOINTS

if TYPE_CHECKING:  # config checks import this module: keep that fast
    from slider.env.guide import Guide

TERMS: dict[str, Term] = {}
_Radians2 = Annotated[float, Unit("rad²"), Field(gt=0, le=1e4)]
_Metres2 = Annotated[float, Unit("m²"), Field(gt=0, le=1e4)]
_Radians2PerSecond2 = Annotated[float, Unit("rad²/s²"), Field(gt=0, le=1e4)]
_Metres2PerSecond2 = Annotated[float, Unit("m²/s²"), Field(gt=0, le=1e4)]
_PerSecond = Annotated[float, Unit("1/s"), Field(ge=0, le=1e4)]
_BASE_HEIGHT = NUM_CHANNELS + 2  # column of the reference: z of its base
_DRIVEN = np.array(GAIT_JOINTS)


@dataclass(frozen=True)
class Lyapunov:
    """Control Lyapunov function V = ηᵀPη with η = (y, ẏ/ω) for each output y, ÿ = v.

    P solves the Riccati equation FᵀP + PF − PGR⁻¹GᵀP + Q = 0 with Q = diag(1, q), R = 1 and time in
    units of 1/ω: P = [[√(q + 2), 1], [1, √(q + 2)]]. In seconds, Q = diag(1, q/ω²), R = 1/ω⁴ and V
    is divided by ω. The LQR has the natural frequency ω and the damping ratio √(q + 2)/2.

    Attributes:
        bandwidth: ω [rad/s].
        rate_weight: q.
    """

    bandwidth: float
    rate_weight: float

    @property
    def largest(self) -> float:
        """λ_max(P) = ‖P‖."""
        return math.sqrt(self.rate_weight + 2.0) + 1.0

    def value(self, outputs: Array) -> Array:
        """V (N,) [rad²], summed over K outputs (N, 2, K): values [rad] and rates [rad/s]."""
        y, rate = outputs[:, 0], outputs[:, 1] / self.bandwidth
        diagonal = self.largest - 1.0
        return (diagonal * (y**2 + rate**2) + 2.0 * y * rate).sum(axis=1)


class RewardView:
    """A view together with the guide, if there is one; the reference is looked up once per step.

    ``before``: ``outputs`` (N, 2, 10) of the previous control step; infinite as an episode starts.
    """

    def __init__(self, view: View, guide: "Guide | None", before: Array | float = math.inf) -> None:
        self.view, self.state, self.outputs_before = view, view.state, before
        self._guide = guide

    @property
    def guide(self) -> "Guide":
        """Guide from the gait library; a ``UserError`` if the training has none."""
        if self._guide is None:
            raise UserError("reward: expected a gait library for its guide terms, found none")
        return self._guide

    @cached_property
    def reference(self) -> Array:
        """Reference channels and base motion (N, 39)."""
        return self.guide.at_phase(self.view)

    @cached_property
    def outputs(self) -> Array:
        """y and ẏ (N, 2, 10) [rad, rad/s]: y = √w (q − gait(phase)) of the driven joints.

        The guide's weights w make 1 m of slide count as √40 rad.
        """
        desired = self.reference[:, : 2 * NUM_JOINTS].reshape(-1, 2, NUM_JOINTS)
        measured = [self.state.joint_positions, self.state.joint_velocities]
        error = namespace(desired).stack(measured, dim=1) - desired
        return (self.guide.weights.sqrt() * error)[:, :, _DRIVEN]


def reward(needs: Needs = Needs.NOTHING) -> Callable[[Function], Function]:
    """Declare a reward term: a function of a :class:`RewardView` and parameters, returning (N,)."""
    return lambda function: register(TERMS, Term(function, needs))


def _kernel(square: Array, width: Array | float) -> Array:
    return (-square / width).exp()


def _norm(values: Array) -> Array:
    return (values**2).sum(dim=1).sqrt()


@reward()
def alive(r: RewardView) -> Array:
    """Constant 1."""
    return r.state.yaw.new_ones(r.state.num_robots)


@reward()
def forward_velocity(r: RewardView) -> Array:
    """1 − tanh|e|, e = forward velocity − reference velocity; has a gradient at every error."""
    error = r.state.heading_velocity - r.view.reference_velocity
    return 1.0 - abs(error[:, 0]).tanh()


@reward()
def forward_velocity_filtered(
    r: RewardView, width: _Metres2PerSecond2, relative: NonNegative[Number]
) -> Array:
    """exp(−e²/(width + relative·r²)), e = v − r: filtered forward velocity v and reference r."""
    expected = r.view.expected_velocity[:, 0]
    error = r.view.filtered_velocity[:, 0] - expected
    return _kernel(error**2, width + relative * expected**2)


@reward()
def lateral_velocity_filtered(r: RewardView, width: Positive[MetresPerSecond]) -> Array:
    """1 − tanh(|e|/width), e = filtered leftward velocity − filtered reference velocity."""
    error = r.view.filtered_velocity[:, 1] - r.view.expected_velocity[:, 1]
    return 1.0 - (abs(error) / width).tanh()


@reward()
def yaw_rate(r: RewardView, width: _Radians2PerSecond2) -> Array:
    """exp(−e²/width), e = z component of the angular velocity − commanded yaw rate."""
    return _kernel((r.state.angular_velocity[:, 2] - r.view.command[:, 2]) ** 2, width)


@reward()
def heading(r: RewardView, width: _Radians2) -> Array:
    """exp(−e²/width), e = heading error."""
    return _kernel(r.view.command[:, 3] ** 2, width)


@reward(Needs.CLOCK | Needs.LIBRARY)
def guide_phase(r: RewardView, width: _Radians2) -> Array:
    """exp(−‖q − gait(phase)‖²_w/width): the gait as a time-indexed reference."""
    error = r.state.joint_positions - r.reference[:, :NUM_JOINTS]
    return _kernel((r.guide.weights * error**2).sum(dim=1), width)


@reward(Needs.CLOCK | Needs.LIBRARY)
def guide_phase_turning(r: RewardView, width: _Radians2) -> Array:
    """``guide_phase`` with the hip yaw that a commanded turn adds to the gait (``Guide.turn``)."""
    error = r.state.joint_positions - r.reference[:, :NUM_JOINTS] - r.guide.turn(r.view)
    return _kernel((r.guide.weights * error**2).sum(dim=1), width)


@reward(Needs.CLOCK | Needs.LIBRARY)
def clf_value(
    r: RewardView,
    bandwidth: Positive[RadiansPerSecond],
    rate_weight: NonNegative[Number],
    eta_max: Positive[Radians],
) -> Array:
    """exp(−V/σ), V the control Lyapunov function of the outputs, σ = λ_max(P) η_max² (CLF-RL)."""
    clf = Lyapunov(bandwidth, rate_weight)
    return _kernel(clf.value(r.outputs), clf.largest * eta_max**2)


@reward(Needs.CLOCK | Needs.LIBRARY)
def clf_decrease(
    r: RewardView,
    bandwidth: Positive[RadiansPerSecond],
    rate_weight: NonNegative[Number],
    eta_max: Positive[Radians],
    eta_dot_max: Positive[RadiansPerSecond],
    decay: _PerSecond,
) -> Array:
    """Violation of V̇ + decay·V ≤ 0 divided by σ', clipped to [0, 1] (CLF-RL).

    V̇ is the finite difference over a control step; σ' = 2‖P‖ η_max η̇_max + decay λ_max(P) η_max².
    The term is 0 in the first step of an episode, because the previous V is then infinite.
    """
    clf = Lyapunov(bandwidth, rate_weight)
    value, before = clf.value(r.outputs), clf.value(r.outputs_before)
    scale = clf.largest * eta_max * (2.0 * eta_dot_max + decay * eta_max)
    return (((value - before) / r.view.period + decay * value) / scale).clip(0.0, 1.0)


@reward()
def stand_still(r: RewardView, loaded: Newtons, width: _Radians2PerSecond2) -> Array:
    """At zero command: share of feet above ``loaded``, times exp(−‖q̇‖²/width); else 0."""
    share = (1.0 * (r.state.foot_forces > loaded)).mean(dim=1)
    speed = (r.state.joint_velocities**2).sum(dim=1)
    return standing(r.view.command) * share * _kernel(speed, width)


@reward(Needs.LIBRARY)
def guide_nearest(r: RewardView, masked: Share) -> Array:
    """−‖Ô − Ĝ‖ to the nearest gait sample (eq. 3); ``masked`` > 0 omits the upper feet."""
    return -r.guide.nearest_distance(r.view, masked > 0)


@reward(Needs.CLOCK)
def contact_schedule(
    r: RewardView, loaded: Newtons, unloaded: Newtons, margin: Annotated[Share, Field(le=0.5)]
) -> Array:
    """0.5 for a loaded stance foot plus 0.5 for an unloaded swing foot, by the clock's phase.

    Within a share ``margin`` of the step time from either end of a step, the term is 1.
    """
    left, forces = r.view.phase < 0.5, r.state.foot_forces
    stance = forces[:, 0].where(left, forces[:, 1])
    swing = forces[:, 1].where(left, forces[:, 0])
    progress = (2.0 * r.view.phase) % 1.0
    asked = (progress > margin) & (progress < 1.0 - margin)
    return (0.5 * (stance > loaded) + 0.5 * (swing < unloaded)).where(asked, 1.0)


@reward()
def upright(r: RewardView, width: Positive[Number]) -> Array:
    """exp(−(g_x² + g_y²)/width) of the projected gravity."""
    return _kernel((r.state.gravity[:, :2] ** 2).sum(dim=1), width)


@reward()
def height(r: RewardView, width: _Metres2) -> Array:
    """exp(−(z − nominal height)²/width), z = base height."""
    return _kernel((r.state.base_height - r.view.nominal_height) ** 2, width)


@reward(Needs.CLOCK | Needs.LIBRARY)
def guide_height(r: RewardView, width: _Metres2) -> Array:
    """exp(−(z − gait(phase))²/width), z = base height."""
    return _kernel((r.state.base_height - r.reference[:, _BASE_HEIGHT]) ** 2, width)


@reward()
def action_rate(r: RewardView) -> Array:
    """Σ (a − a_previous)²."""
    return ((r.view.action - r.view.previous_action) ** 2).sum(dim=1)


@reward()
def roll_pitch_rate(r: RewardView) -> Array:
    """ω_x² + ω_y² [rad²/s²]."""
    return (r.state.angular_velocity[:, :2] ** 2).sum(dim=1)


@reward()
def effort(r: RewardView) -> Array:
    """Σ (motor torque/limit)²."""
    return ((r.state.motor_torques / r.view.torque_limits) ** 2).sum(dim=1)


@reward()
def foot_slip(r: RewardView, loaded: Newtons, width: _Metres2PerSecond2) -> Array:
    """Σ over loaded feet of 1 − exp(−v²/width), v the horizontal speed of the sole."""
    square = (r.state.foot_velocities[:, :, :2] ** 2).sum(dim=2)
    return ((1.0 - _kernel(square, width)) * (r.state.foot_forces > loaded)).sum(dim=1)


@reward()
def soft_landing(
    r: RewardView, speed: NonNegative[MetresPerSecond], height: Positive[Metres]
) -> Array:
    """Σ over feet of exp(−z/height)·max(v − speed, 0) [m/s].

    z is the height of the sole above the ground, v its downward speed. The exponential limits the
    term to feet that are about to land.
    """
    soles = r.state.foot_positions
    above = soles[..., 2] - r.state.ground.height(soles[..., :2], gaps=False)
    excess = (-r.state.foot_velocities[..., 2] - speed).clip(min=0.0)
    return ((-above.clip(min=0.0) / height).exp() * excess).sum(dim=1)


@reward()
def airborne(r: RewardView, unloaded: Newtons) -> Array:
    """1 where both feet carry less than ``unloaded``."""
    free = r.state.foot_forces < unloaded
    return 1.0 * (free[:, 0] & free[:, 1])


@reward()
def feet_close(r: RewardView, least: Positive[Metres]) -> Array:
    """max(1 − d/least, 0), d = lateral position of the left sole relative to the right one."""
    way = r.state.foot_positions[:, 0] - r.state.foot_positions[:, 1]
    distance = turn_to_heading(way, r.state.yaw)[:, 1]
    return (1.0 - distance / least).clip(min=0.0)


@reward()
def torque_tanh(r: RewardView) -> Array:
    """tanh‖τ‖ of the motor torques (paper)."""
    return _norm(r.state.motor_torques).tanh()


@reward()
def angular_velocity_tanh(r: RewardView) -> Array:
    """tanh‖ω‖, ω = angular velocity of the base (paper)."""
    return _norm(r.state.angular_velocity).tanh()


@reward()
def linear_error_tanh(r: RewardView) -> Array:
    """tanh‖v − v_des‖, base frame, three components (paper)."""
    return _norm(r.state.linear_velocity - target_linear_velocity(r.view)).tanh()


@reward()
def angular_error_tanh(r: RewardView) -> Array:
    """tanh‖ω − ω_des‖ (paper)."""
    return _norm(r.state.angular_velocity - target_angular_velocity(r.view)).tanh()


@reward()
def height_tanh(r: RewardView) -> Array:
    """tanh(H), H = base height [m] (paper)."""
    return r.state.base_height.tanh()


@reward()
def action_rate_tanh(r: RewardView) -> Array:
    """tanh‖A − A_previous‖, A the position commands [rad or m] (paper)."""
    change = r.view.action - r.view.previous_action
    return _norm(r.view.action_scale * change).tanh()


class Reward:
    """The configured sum of terms."""

    def __init__(self, config: RewardConfig) -> None:
        check(config.terms)
        self._config = config

    def __call__(self, r: RewardView, fell: Array) -> tuple[Array, dict[str, Array]]:
        """Reward (N,), and the weighted terms by name (N,), before ``floor`` and ``scale``."""
        config = self._config
        parts = {n: t.weight * TERMS[n].function(r, **t.params) for n, t in config.active.items()}
        total: Array = sum(parts.values(), r.state.yaw.new_zeros(r.state.num_robots))
        total = total.clip(min=config.floor) * config.scale
        return total + config.on_fall * fell, parts


def check(terms: Mapping[str, RewardTerm], key: str = "reward.terms") -> None:
    """Raise a ``UserError`` for unknown terms and missing, unknown or out-of-bounds parameters."""
    check_names(TERMS, terms, key)
    for name, term in terms.items():
        expected = TERMS[name].parameters
        if set(term.params) != set(expected):
            texts = [", ".join(sorted(names)) or "none" for names in (expected, term.params)]
            raise UserError(f"{key}.{name}.params: expected {texts[0]}, found {texts[1]}")
        for parameter, value in term.params.items():
            from_dict(expected[parameter], value, f"{key}.{name}.params.{parameter}")
