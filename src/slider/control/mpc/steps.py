"""Steps of the walking robots: start, end, footholds and swing foot."""

import numpy as np

from slider.config.control import MpcConfig
from slider.control.mpc import swing
from slider.control.mpc.footsteps import FootstepPlanner, Pendulum
from slider.control.mpc.single_support import SingleSupport
from slider.control.whole_body.controller import Surroundings
from slider.control.whole_body.memory import LEFT, Memory
from slider.control.whole_body.nominal import Dynamics
from slider.control.whole_body.tasks import Solved
from slider.control.whole_body.velocity import ReferenceVelocity


class Steps:
    """Plans and advances steps.

    Args:
        config: settings of the baseline.
        around: the robot.
    """

    def __init__(self, config: MpcConfig, around: Surroundings) -> None:
        self._config, self._period, self._clock = config, around.period, around.clock
        self._velocity = ReferenceVelocity(config.velocity, around.period)
        self._planner = FootstepPlanner(config.step, config.planner, around.omega)
        self._support = SingleSupport(config, around.body, around.model.nominal_height)
        self._ticks_per_plan = max(1, round(config.planner.period / around.period))

    def reset(self, count: int) -> None:
        """Nothing: the memory has it all."""

    def command(self, memory: Memory, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on."""
        self._velocity.change(memory, velocity)

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
        self._plan(memory, robots, dynamics, np.arange(len(robots)))

    def end(self, memory: Memory, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Whether the steps are over (n,), where ``contact`` (n,) is that of the swing feet."""
        step, elapsed = self._config.step, memory.elapsed[robots] + 1e-9
        duration = memory.duration[robots]
        if step.switching == "time":
            return elapsed >= duration
        return (contact & (elapsed > step.early * duration)) | (elapsed > duration + step.late)

    def torques(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> Solved:
        """Torques of this tick."""
        self._advance(memory, robots, dynamics)
        return self._support.torques(memory, robots, dynamics)

    def _advance(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """One tick on, with a new plan where it is time for one."""
        config = self._config
        if memory.tick % self._ticks_per_plan == 0:
            left = memory.duration[robots] - memory.elapsed[robots]
            due = np.flatnonzero(left > config.planner.lock)
            self._plan(memory, robots[due], dynamics, due)
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

    def _plan(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, rows: np.ndarray
    ) -> None:
        """Foothold and duration of the steps of ``robots`` from their ``rows`` of the terms."""
        if not len(robots):
            return
        stance = memory.stance[robots]
        foot = dynamics.foot_positions[rows, stance, :2]
        pendulum = Pendulum(
            position=memory.to_heading(dynamics.com[rows, :2] - foot, robots),
            velocity=memory.to_heading(dynamics.com_velocity[rows, :2], robots),
            swing_sign=np.where(stance == LEFT, -1.0, 1.0),
            elapsed=memory.elapsed[robots],
            duration=memory.duration[robots],
            command=self._velocity.of(memory, robots),
        )
        with self._clock.part("footsteps"):
            plan = self._planner.plan(pendulum)
        memory.foothold[robots] = foot + memory.to_world(plan.step, robots)
        memory.duration[robots] = plan.duration
