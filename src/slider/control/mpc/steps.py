"""Steps of the walking robots: start, end, footholds, swing foot and reference velocity."""

import numpy as np

from slider.config.control import MpcConfig, PlannerConfig
from slider.control.mpc import swing
from slider.control.mpc.clock import TickClock
from slider.control.mpc.footsteps import FootstepPlanner, Pendulum
from slider.control.mpc.memory import LEFT, Gait
from slider.control.mpc.nominal import Dynamics
from slider.robot.kinematics import turn_to_heading


class ReferenceVelocity:
    """Follows the command.

    Args:
        config: acceleration and integral action.
        period: of a tick [s].
    """

    def __init__(self, config: PlannerConfig, period: float) -> None:
        self._config, self._period = config, period

    def change(self, gait: Gait, command: np.ndarray) -> None:
        """Go with ``command`` (N, 3) from now on; the reference grows from where it is."""
        changed = np.flatnonzero((command != gait.command).any(axis=1))
        gait.old[changed] = self._on_the_way(gait, changed)
        gait.changed[changed] = gait.walked[changed]
        gait.correction[changed] = 0.0
        gait.steps[changed] = np.minimum(gait.steps[changed], 1)  # no error of a stride in between
        gait.command = command

    def of(self, gait: Gait, robots: np.ndarray) -> np.ndarray:
        """Velocity (n, 2) forward, left [m/s] that the steps are planned for."""
        return self._on_the_way(gait, robots) + gait.correction[robots]

    def _on_the_way(self, gait: Gait, robots: np.ndarray) -> np.ndarray:
        """From the old command to the new one with constant acceleration (n, 2) [m/s]."""
        old = gait.old[robots]
        change = gait.command[robots, :2] - old
        size = np.maximum(np.linalg.norm(change, axis=1), 1e-9)
        time = gait.walked[robots] - gait.changed[robots]
        share = np.minimum(1.0, self._config.acceleration * time / size)
        return old + change * share[:, None]

    def correct(self, gait: Gait, robots: np.ndarray, com: np.ndarray) -> None:
        """Add the velocity error of the last stride at the start of a step.

        Args:
            gait: memory, of which ``starts`` and ``correction`` change.
            robots: that start a step (n,).
            com: their centres of mass (n, 2) [m], world.
        """
        now = np.concatenate([com, gait.walked[robots, None]], axis=1)
        gone = now - gait.starts[robots, 0]
        gait.starts[robots] = np.stack([gait.starts[robots, 1], now], axis=1)
        # Not in the first stride, nor while it brakes in order to stand.
        known = (gait.steps[robots] > 2) & ~gait.told_to_stand(robots)
        halfway = gait.heading[robots] - 0.5 * gait.command[robots, 2] * gone[:, 2]
        mean = turn_to_heading(gone, halfway) / np.maximum(gone[:, 2:], self._period)
        error = np.where(known[:, None], gait.command[robots, :2] - mean, 0.0)
        limit = self._config.integral_limit
        total = gait.correction[robots] + self._config.integral * error
        gait.correction[robots] = np.clip(total, -limit, limit)


class Steps:
    """Plans and advances steps.

    Args:
        config: settings of the baseline.
        omega: natural frequency of the pendulum [rad/s].
        velocity: what the steps are planned for.
        period: of a tick [s].
        clock: for the part ``footsteps``.
    """

    def __init__(
        self,
        config: MpcConfig,
        omega: float,
        velocity: ReferenceVelocity,
        period: float,
        clock: TickClock,
    ) -> None:
        self._config, self._velocity = config, velocity
        self._period, self._clock = period, clock
        self._planner = FootstepPlanner(config.step, config.planner, omega)
        self._ticks_per_plan = max(1, round(config.planner.period / period))

    def begin(self, gait: Gait, robots: np.ndarray, dynamics: Dynamics, stance: np.ndarray) -> None:
        """A new step on the feet ``stance`` (n,)."""
        if not len(robots):
            return
        gait.stance[robots] = stance
        gait.elapsed[robots] = 0.0
        gait.duration[robots] = self._config.step.time
        start = dynamics.foot_positions[np.arange(len(robots)), 1 - stance]
        gait.swing[robots] = swing.begin(start)
        gait.steps[robots] += 1
        self._velocity.correct(gait, robots, dynamics.com[:, :2])
        self._plan(gait, robots, dynamics)

    def end(self, gait: Gait, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Whether the steps are over (n,), where ``contact`` (n,) is that of the swing feet."""
        step, elapsed = self._config.step, gait.elapsed[robots] + 1e-9
        duration = gait.duration[robots]
        if step.switching == "time":
            return elapsed >= duration
        return (contact & (elapsed > step.early * duration)) | (elapsed > duration + step.late)

    def advance(self, gait: Gait, robots: np.ndarray, dynamics: Dynamics) -> None:
        """One tick on, with a new plan where it is time for one."""
        config = self._config
        if gait.tick % self._ticks_per_plan == 0:
            due = gait.duration[robots] - gait.elapsed[robots] > config.planner.lock
            self._plan(gait, robots[due], dynamics.of(due))
        ground = dynamics.foot_positions[np.arange(len(robots)), gait.stance[robots], 2]
        gait.swing[robots] = swing.advance(
            gait.swing[robots],
            gait.foothold[robots],
            gait.elapsed[robots],
            gait.duration[robots],
            ground + config.swing.compression,
            config.step.apex,
            config.swing,
            self._period,
        )
        gait.elapsed[robots] += self._period
        gait.walked[robots] += self._period

    def _plan(self, gait: Gait, robots: np.ndarray, dynamics: Dynamics) -> None:
        """Foothold and duration of the steps from the state of the pendulums."""
        if not len(robots):
            return
        stance = gait.stance[robots]
        foot = dynamics.foot_positions[np.arange(len(robots)), stance, :2]
        pendulum = Pendulum(
            position=gait.to_heading(dynamics.com[:, :2] - foot, robots),
            velocity=gait.to_heading(dynamics.com_velocity[:, :2], robots),
            swing_sign=np.where(stance == LEFT, -1.0, 1.0),
            elapsed=gait.elapsed[robots],
            duration=gait.duration[robots],
            command=self._velocity.of(gait, robots),
        )
        with self._clock.part("footsteps"):
            plan = self._planner.plan(pendulum)
        gait.foothold[robots] = foot + gait.to_world(plan.step, robots)
        gait.duration[robots] = plan.duration
