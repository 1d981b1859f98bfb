"""Steps of the walking robots: start, end, footholds, swing foot and reference velocity."""

import numpy as np

from slider.config.control import MpcConfig, PlannerConfig
from slider.control.mpc import swing
from slider.control.mpc.clock import TickClock
from slider.control.mpc.footsteps import FootstepPlanner, Pendulum
from slider.control.mpc.memory import LEFT, Memory
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

    def change(self, memory: Memory, command: np.ndarray) -> None:
        """Go with ``command`` (N, 3) from now on; the reference grows from where it is."""
        changed = np.flatnonzero((command != memory.command).any(axis=1))
        memory.old[changed] = self._on_the_way(memory, changed)
        memory.changed[changed] = memory.walked[changed]
        memory.correction[changed] = 0.0
        memory.steps[changed] = np.minimum(
            memory.steps[changed], 1
        )  # no error of a stride in between
        memory.command = command

    def of(self, memory: Memory, robots: np.ndarray) -> np.ndarray:
        """Velocity (n, 2) forward, left [m/s] that the steps are planned for."""
        return self._on_the_way(memory, robots) + memory.correction[robots]

    def _on_the_way(self, memory: Memory, robots: np.ndarray) -> np.ndarray:
        """From the old command to the new one with constant acceleration (n, 2) [m/s]."""
        old = memory.old[robots]
        change = memory.command[robots, :2] - old
        size = np.maximum(np.linalg.norm(change, axis=1), 1e-9)
        time = memory.walked[robots] - memory.changed[robots]
        share = np.minimum(1.0, self._config.acceleration * time / size)
        return old + change * share[:, None]

    def correct(self, memory: Memory, robots: np.ndarray, com: np.ndarray) -> None:
        """Add the velocity error of the last stride at the start of a step.

        Args:
            memory: memory, of which ``starts`` and ``correction`` change.
            robots: that start a step (n,).
            com: their centres of mass (n, 2) [m], world.
        """
        now = np.concatenate([com, memory.walked[robots, None]], axis=1)
        gone = now - memory.starts[robots, 0]
        memory.starts[robots] = np.stack([memory.starts[robots, 1], now], axis=1)
        # Not in the first stride, nor while it brakes in order to stand.
        known = (memory.steps[robots] > 2) & ~memory.commanded_to_stand(robots)
        halfway = memory.heading[robots] - 0.5 * memory.command[robots, 2] * gone[:, 2]
        mean = turn_to_heading(gone, halfway) / np.maximum(gone[:, 2:], self._period)
        error = np.where(known[:, None], memory.command[robots, :2] - mean, 0.0)
        limit = self._config.integral_limit
        total = memory.correction[robots] + self._config.integral * error
        memory.correction[robots] = np.clip(total, -limit, limit)


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

    def begin(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, stance: np.ndarray
    ) -> None:
        """A new step on the feet ``stance`` (n,)."""
        if not len(robots):
            return
        memory.stance[robots] = stance
        memory.elapsed[robots] = 0.0
        memory.duration[robots] = self._config.step.time
        start = dynamics.foot_positions[np.arange(len(robots)), 1 - stance]
        memory.swing[robots] = swing.begin(start)
        memory.steps[robots] += 1
        self._velocity.correct(memory, robots, dynamics.com[:, :2])
        self._plan(memory, robots, dynamics)

    def end(self, memory: Memory, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Whether the steps are over (n,), where ``contact`` (n,) is that of the swing feet."""
        step, elapsed = self._config.step, memory.elapsed[robots] + 1e-9
        duration = memory.duration[robots]
        if step.switching == "time":
            return elapsed >= duration
        return (contact & (elapsed > step.early * duration)) | (elapsed > duration + step.late)

    def advance(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """One tick on, with a new plan where it is time for one."""
        config = self._config
        if memory.tick % self._ticks_per_plan == 0:
            due = memory.duration[robots] - memory.elapsed[robots] > config.planner.lock
            self._plan(memory, robots[due], dynamics.of(due))
        ground = dynamics.foot_positions[np.arange(len(robots)), memory.stance[robots], 2]
        memory.swing[robots] = swing.advance(
            memory.swing[robots],
            memory.foothold[robots],
            memory.elapsed[robots],
            memory.duration[robots],
            ground + config.swing.compression,
            config.step.apex,
            config.swing,
            self._period,
        )
        memory.elapsed[robots] += self._period
        memory.walked[robots] += self._period

    def _plan(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """Foothold and duration of the steps from the state of the pendulums."""
        if not len(robots):
            return
        stance = memory.stance[robots]
        foot = dynamics.foot_positions[np.arange(len(robots)), stance, :2]
        pendulum = Pendulum(
            position=memory.to_heading(dynamics.com[:, :2] - foot, robots),
            velocity=memory.to_heading(dynamics.com_velocity[:, :2], robots),
            swing_sign=np.where(stance == LEFT, -1.0, 1.0),
            elapsed=memory.elapsed[robots],
            duration=memory.duration[robots],
            command=self._velocity.of(memory, robots),
        )
        with self._clock.part("footsteps"):
            plan = self._planner.plan(pendulum)
        memory.foothold[robots] = foot + memory.to_world(plan.step, robots)
        memory.duration[robots] = plan.duration
