"""Footstep MPC: positions of the next steps on the LIP, from small QPs in the step lengths.

Forward and sideways axes are independent. With ξ₀ the state at the end of the current step relative
to its foot and dₖ the length of step k, the state at the end of step k is
ξₖ = Aᵏ ξ₀ − Σⱼ Aᵏ⁻ʲ⁺¹ e₁ dⱼ, so the velocities there are v = f(ξ₀) + F d. The QP is
min Σ (vₖ − v̂ₖ)² + w Σ (dₖ − d̂ₖ)² with bounds on d (largest step; feet do not cross). Its matrices
depend on the nominal duration of a step, which may grow with the speed.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from slider.config.control import PlannedStepConfig, PlannerConfig
from slider.control import qp
from slider.control.whole_body import references


@dataclass(frozen=True)
class Pendulum:
    """States of n robots at planning time in the heading frame, relative to the stance foot.

    Attributes:
        position, velocity: of the centre of mass (n, 2) forward, left [m], [m/s].
        swing_sign: (n,) +1 where the left foot is in the air, −1 for the right one.
        elapsed: time in this step (n,) [s].
        duration: planned time of this step (n,) [s].
        reference_velocity: reference velocity (n, 2) [m/s].
    """

    position: np.ndarray
    velocity: np.ndarray
    swing_sign: np.ndarray
    elapsed: np.ndarray
    duration: np.ndarray
    reference_velocity: np.ndarray


class Plan(NamedTuple):
    """Next step of n robots: (n, 2) from the stance foot [m], its time (n,) [s], cost (n,)."""

    step: np.ndarray
    duration: np.ndarray
    cost: np.ndarray


class FootstepPlanner:
    """Plans the next step of n robots, pendulums of natural frequency ``omega`` [rad/s]."""

    def __init__(self, step: PlannedStepConfig, config: PlannerConfig, omega: float) -> None:
        self._step, self._config, self.omega = step, config, omega
        self._signs = (-1.0) ** np.arange(config.steps)
        changes = (0.0, -step.time_change, step.time_change)[: 3 if step.time_change else 1]
        self._changes = np.array(changes)[:, None]

    def nominal_time(self, velocity: np.ndarray) -> np.ndarray:
        """Duration (n,) [s] of steps at reference velocities (n, 2) [m/s]."""
        step = self._step
        time = step.time + step.time_per_speed * np.abs(velocity[:, 0])
        return np.clip(time, step.time_min, step.time_max)

    def plan(self, pendulum: Pendulum) -> Plan:
        """The best next step over all candidates of the current step's duration."""
        duration = pendulum.duration + self._changes
        lengths, cost = self.solve(pendulum, duration - pendulum.elapsed)
        nominal = self.nominal_time(pendulum.reference_velocity)
        cost = cost + self._config.time_weight * (duration - nominal) ** 2
        in_range = (duration >= self._step.time_min) & (duration <= self._step.time_max)
        allowed = in_range & (duration - pendulum.elapsed >= 2 * self._config.lock)
        cost[1:] = np.where(allowed[1:], cost[1:], np.inf)  # the planned duration is always allowed
        best = cost.argmin(axis=0), np.arange(cost.shape[1])
        return Plan(lengths[best][:, :, 0], duration[best], cost[best])

    def solve(self, pendulum: Pendulum, remaining: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Lengths of the next steps (…, n, 2, N) [m] and cost (…, n), for times left (…, n) [s]."""
        start = np.stack([pendulum.position, pendulum.velocity], axis=-1)  # (n, axis, 2)
        end = np.einsum("...nij,naj->...nai", references.step_map(self.omega, remaining), start)
        speeds, lengths, lower, upper = self.references(pendulum)
        free_map, effect, hessian = self._prediction(self.nominal_time(pendulum.reference_velocity))
        free = end @ free_map.swapaxes(-1, -2) - speeds
        gradient = free @ effect - self._config.length_weight * lengths
        result = -gradient @ np.linalg.inv(hessian)
        outside = ((result < lower) | (result > upper)).any(axis=-1)
        if outside.any():  # a QP only where a bound is active
            *_, robots, axes = np.nonzero(outside)
            low, high, slope = lower[robots, axes], upper[robots, axes], gradient[outside]
            rows = np.zeros((len(slope), 0, slope.shape[1]))
            bounded, solved = qp.solve(hessian[robots], slope, rows, low, high)
            bounded = np.where(solved[:, None], bounded, result[outside])
            result[outside] = np.clip(bounded, low, high)
        quadratic = ((result @ hessian) * result).sum(axis=-1)
        constant = (free**2).sum(axis=-1) + self._config.length_weight * (lengths**2).sum(axis=-1)
        cost = quadratic + 2 * (gradient * result).sum(axis=-1) + constant
        return result, cost.sum(axis=-1)

    def _prediction(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Velocities at the ends of steps of nominal durations ``time`` (n,) [s].

        They are free (n, N, 2) ξ₀ + effect (n, N, N) d; the third is the QPs' Hessian (n, N, N).
        """
        count, one = self._config.steps, references.step_map(self.omega, time)
        powers = [np.broadcast_to(np.eye(2), one.shape)]
        for _ in range(count):
            powers.append(powers[-1] @ one)
        effect = np.zeros((len(time), count, count))
        for end in range(count):
            for length in range(end + 1):
                effect[:, end, length] = -powers[end - length + 1][:, 1, 0]
        weight = self._config.length_weight * np.eye(count)
        free = np.stack([power[:, 1] for power in powers[1:]], axis=1)
        return free, effect, effect.swapaxes(1, 2) @ effect + weight

    def references(
        self, pendulum: Pendulum
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """References of step-end velocities and of step lengths, and two bounds, each (n, 2, N)."""
        step, config = self._step, self._config
        time = self.nominal_time(pendulum.reference_velocity)[:, None]
        shape = (len(pendulum.elapsed), 2, config.steps)
        side = pendulum.swing_sign[:, None] * self._signs  # +1: on to the left foot
        along = np.broadcast_to(pendulum.reference_velocity[:, :, None], shape)
        speeds = along.copy()
        if config.speed == "mean":
            speeds = references.forward_end_velocity(self.omega, time[..., None], along)
        speeds[:, 1] -= side * references.lateral_end_velocity(self.omega, time, step.width)
        lengths = along * time[..., None]
        lengths[:, 1] += side * step.width
        lower, upper = np.full(shape, -config.length_max), np.full(shape, config.length_max)
        lower[:, 1] = np.where(side > 0, config.width_min, -config.width_max)
        upper[:, 1] = np.where(side > 0, config.width_max, -config.width_min)
        return speeds, lengths, lower, upper
