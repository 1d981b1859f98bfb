"""State machine: standing robots sway, then walk; at zero command they step until they can stop.

STAND → SWAY → WALK → STAND. Where a mode or a step ends is decided here, once per tick. The sway in
double support leads from rest into the sideways orbit, and its exit is closed-loop.
"""

from typing import Protocol

import numpy as np

from slider.config.control import EntryConfig, StepConfig
from slider.control.whole_body import references
from slider.control.whole_body.memory import (
    FEET,
    LEFT,
    RIGHT,
    STAND,
    SWAY,
    WALK,
    Memory,
    Sway,
    scatter,
    take,
)
from slider.control.whole_body.model import Dynamics
from slider.control.whole_body.tasks import Solved


class Stepping(Protocol):
    """A way of stepping, for the robots (n,) of a memory that walk."""

    def reset(self, count: int) -> None:
        """Forget the steps of ``count`` robots."""

    def set_velocity(self, memory: Memory, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on."""

    def begin(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, stance: np.ndarray
    ) -> None:
        """A new step on the feet ``stance`` (n,)."""

    def end(self, memory: Memory, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Whether the steps are over (n,), where ``contact`` (n,) is that of the swing feet."""
        ...

    def torques(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> Solved:
        """Torques of this tick."""
        ...


class Entry:
    """Sways towards the first stance foot until the pendulum has the energy of the orbit.

    Args:
        step: times and width.
        config: settings of the entry.
        omega: natural frequency of the pendulum [rad/s].
        reach: forward distance from the middle within which a robot can come to a stop [m].
    """

    def __init__(self, step: StepConfig, config: EntryConfig, omega: float, reach: float) -> None:
        self._config, self._omega, self._reach = config, omega, reach
        self._width, self._step_time = step.width, step.time
        self._speed = references.lateral_end_velocity(omega, step.time, step.width)
        half = step.width / 2
        self.energy = float(references.orbital_energy(omega, np.array([-half, self._speed])))

    def begin(
        self, middle: np.ndarray, position: np.ndarray, side: np.ndarray, speed: np.ndarray
    ) -> Sway:
        """Sway of robots at rest at ``position`` (n, 2) for a forward ``speed`` (n,) [m/s].

        The centre of pressure p lies behind the middle so that the pendulum, after the sway and a
        step on a foot in the middle, has the velocity at the end of the orbit's steps,
        v = −ω p (sinh ω(t + T) − sinh ωT), if the foot is long enough for that.
        """
        start = np.zeros((len(middle), 3))
        start[:, 0] = side * (position - middle)[:, 1]
        omega, step = self._omega, self._step_time
        end = references.forward_end_velocity(omega, step, speed)
        gain = np.sinh(omega * (self._config.duration + step)) - np.sinh(omega * step)
        ideal = -end / (omega * gain)
        centre = np.clip(ideal, -self._config.push, self._config.push)
        return Sway(middle, side, start, centre, np.zeros(len(middle)))

    def reference(self, sway: Sway) -> np.ndarray:
        """Forward and leftward place from the middle, velocity, acceleration (n, 2, 3)."""
        sideways = sway.side[:, None] * self._sideways(sway)
        return np.stack([self._forward(sway), sideways], axis=1)

    def _forward(self, sway: Sway) -> np.ndarray:
        """The pendulum with its centre of pressure in ``centre``, from rest."""
        omega, phase = self._omega, self._omega * sway.elapsed
        cosh, sinh = np.cosh(phase), np.sinh(phase)
        unit = np.stack([1 - cosh, -omega * sinh, -(omega**2) * cosh], axis=-1)
        return sway.centre[:, None] * unit

    def _sideways(self, sway: Sway) -> np.ndarray:
        """A quintic to the middle with the speed of the orbit there; past its end straight on."""
        duration = np.full(len(sway.elapsed), self._config.duration)
        goal = np.tile([0.0, self._speed, 0.0], (len(duration), 1))
        late = sway.elapsed > duration
        result = references.quintic(sway.start, goal, duration, np.minimum(sway.elapsed, duration))
        result[late, 0] += self._speed * (sway.elapsed - duration)[late]
        return result

    def done(
        self, sway: Sway, position: np.ndarray, velocity: np.ndarray, foot: np.ndarray
    ) -> np.ndarray:
        """Robots (n,) that can take their first step, or have to.

        They can, when the centre of mass goes towards the stance foot with the orbit's energy and
        forward as planned; they have to, when their time is over and they could not stop any
        more: the capture point x + ẋ/ω is beyond the feet.

        Args:
            sway: their references.
            position, velocity: of the centre of mass (n, 2) [m], [m/s].
            foot: the first stance foot (n, 2) [m].
        """
        sideways = sway.side[:, None] * np.stack([position - foot, velocity], axis=-1)[:, 1]
        energy = references.orbital_energy(self._omega, sideways)
        ready = (sideways[:, 1] > 0) & (energy > self.energy - self._config.tolerance * self._width)
        planned = self._forward(sway)[:, 1]
        calm = np.abs(velocity[:, 0] - planned) < self._config.speed_tolerance
        begun = sway.elapsed > self._config.duration / 2
        capture = (position - sway.middle)[:, 0] + velocity[:, 0] / self._omega
        lost = self._late(sway) & (np.abs(capture) > self._reach)
        return (ready & calm & begun) | lost

    def _late(self, sway: Sway) -> np.ndarray:
        return sway.elapsed > self._config.duration + self._config.patience

    def restart(self, sway: Sway, position: np.ndarray, velocity: np.ndarray) -> None:
        """Sway again, on the spot and from here (n, 2), (n, 2), where time is over."""
        again = self._late(sway)
        sway.start[again, 0] = (sway.side * (position - sway.middle)[:, 1])[again]
        sway.start[again, 1] = (sway.side * velocity[:, 1])[again]
        sway.start[again, 2] = 0.0
        sway.centre[again] = 0.0
        sway.elapsed[again] = 0.0


class Modes:
    """Switches modes and stance feet.

    Args:
        entry: from the sway to the first step.
        steps: the way of stepping.
        omega: natural frequency of the pendulum [rad/s].
        reach: forward distance from the middle within which a robot can come to a stop [m].
    """

    def __init__(self, entry: Entry, steps: Stepping, omega: float, reach: float) -> None:
        self._entry, self._steps = entry, steps
        self._omega, self._reach = omega, reach

    def sway(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """A sway from here, towards the foot that is still in the air."""
        middle = memory.to_heading(dynamics.foot_positions.mean(axis=1)[:, :2], robots)
        position = memory.to_heading(dynamics.com[:, :2], robots)
        height = dynamics.foot_positions[:, :, 2]
        side = np.where(height[:, LEFT] >= height[:, RIGHT], 1.0, -1.0)
        sway = self._entry.begin(middle, position, side, memory.velocity[robots, 0])
        scatter(memory.sway, robots, sway)

    def switch(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray
    ) -> None:
        """Switch the robots that are due; ``contact`` (n, 2) of the feet."""
        self._go(memory, robots, dynamics)
        self._leave_sway(memory, robots, dynamics)
        self._leave_step(memory, robots, dynamics, contact)

    def _go(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """STAND → SWAY where the commanded velocity is not zero."""
        stands = memory.mode[robots] == STAND
        index = np.flatnonzero(stands & ~memory.commanded_to_stand(robots))
        if len(index):
            memory.mode[robots[index]] = SWAY
            self.sway(memory, robots[index], dynamics.take(index))

    def _leave_sway(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """SWAY → WALK."""
        sways = np.flatnonzero(memory.mode[robots] == SWAY)
        if not len(sways):
            return
        index = sways[self._sway_ends(memory, robots[sways], dynamics.take(sways))]
        memory.mode[robots[index]] = WALK
        stance = _first_stance(take(memory.sway, robots[index]))
        self._steps.begin(memory, robots[index], dynamics.take(index), stance)

    def _sway_ends(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        """Whether they can take the first step (n,); those that took too long sway again."""
        sway = take(memory.sway, robots)
        position = memory.to_heading(dynamics.com[:, :2], robots)
        velocity = memory.to_heading(dynamics.com_velocity[:, :2], robots)
        support = dynamics.foot_positions[np.arange(len(robots)), _first_stance(sway), :2]
        done = self._entry.done(sway, position, velocity, memory.to_heading(support, robots))
        self._entry.restart(sway, position, velocity)
        scatter(memory.sway, robots, sway)
        return done

    def _leave_step(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray
    ) -> None:
        """WALK → STAND, or the next step."""
        walks = np.flatnonzero(memory.mode[robots] == WALK)
        landing = contact[walks, 1 - memory.stance[robots[walks]]]
        index = walks[self._steps.end(memory, robots[walks], landing)]
        stops = memory.commanded_to_stand(robots[index])
        if stops.any():
            standing = index[stops]
            stops[stops] = self._can_stop(memory, robots[standing], dynamics.take(standing))
            self._stop(memory, robots[index[stops]], dynamics.take(index[stops]))
            index = index[~stops]
        if not len(index):
            return
        stance = 1 - memory.stance[robots[index]]
        self._steps.begin(memory, robots[index], dynamics.take(index), stance)

    def _can_stop(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        """Where the capture point is between the feet and within their length."""
        capture = dynamics.com[:, :2] + dynamics.com_velocity[:, :2] / self._omega
        feet = [memory.to_heading(dynamics.foot_positions[:, i, :2], robots) for i in FEET]
        place = memory.to_heading(capture, robots)
        apart = np.abs(feet[LEFT] - feet[RIGHT])[:, 0]
        ahead = np.abs(place - 0.5 * (feet[LEFT] + feet[RIGHT]))[:, 0]
        between = (place[:, 1] < feet[LEFT][:, 1]) & (place[:, 1] > feet[RIGHT][:, 1])
        beside = (apart < self._reach) & (ahead < self._reach / 2)
        return between & beside

    def _stop(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        if len(robots):
            memory.mode[robots] = STAND
            memory.forget_walk(robots)
            self.sway(memory, robots, dynamics)


def _first_stance(sway: Sway) -> np.ndarray:
    return np.where(sway.side > 0, LEFT, RIGHT)
