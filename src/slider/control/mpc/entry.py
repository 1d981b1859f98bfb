"""Entry: a sway in double support from rest into the sideways orbit, with a closed-loop exit."""

from dataclasses import dataclass, fields

import numpy as np

from slider.control.mpc import lip
from slider.control.mpc.quintic import follow
from slider.core.config.control import EntryConfig, StepConfig


@dataclass
class Sway:
    """References of n robots that sway, in the frame of their heading.

    Attributes:
        middle: (n, 2) point between the feet [m].
        start: (n, 3) sideways position [m] from the middle, velocity and acceleration at the start.
        centre: (n,) forward place of the centre of pressure from the middle [m].
        elapsed: (n,) [s].
    """

    middle: np.ndarray
    start: np.ndarray
    centre: np.ndarray
    elapsed: np.ndarray

    def of(self, robots: np.ndarray) -> "Sway":
        """A copy for some of the robots."""
        return Sway(*(getattr(self, item.name)[robots] for item in fields(self)))

    def put(self, robots: np.ndarray, other: "Sway") -> None:
        """Overwrite those of some robots."""
        for item in fields(self):
            getattr(self, item.name)[robots] = getattr(other, item.name)


class Entry:
    """Sways towards the left foot, the first stance foot."""

    def __init__(self, step: StepConfig, config: EntryConfig, omega: float) -> None:
        self._config, self._omega = config, omega
        self._width = step.width
        self._speed = lip.lateral_end_velocity(omega, step.time, step.width)
        half = step.width / 2
        self.energy = float(lip.orbital_energy(omega, np.array([-half, self._speed])))

    def begin(self, middle: np.ndarray, position: np.ndarray, command: np.ndarray) -> Sway:
        """Sway of robots at rest at ``position`` (n, 2), commanded to go forward (n,) [m/s].

        The centre of pressure lies behind the middle so that the pendulum reaches the command
        at the end of the sway, v = −ω p sinh(ω t), if the foot is long enough for that.
        """
        start = np.zeros((len(middle), 3))
        start[:, 0] = (position - middle)[:, 1]
        ideal = -command / (self._omega * np.sinh(self._omega * self._config.duration))
        centre = np.clip(ideal, -self._config.push, self._config.push)
        return Sway(middle, start, centre, np.zeros(len(middle)))

    def forward(self, sway: Sway) -> np.ndarray:
        """Forward position from the middle, velocity, acceleration (n, 3) of the pendulum."""
        omega, phase = self._omega, self._omega * sway.elapsed
        cosh, sinh = np.cosh(phase), np.sinh(phase)
        return sway.centre[:, None] * np.stack(
            [1 - cosh, -omega * sinh, -(omega**2) * cosh], axis=-1
        )

    def sideways(self, sway: Sway) -> np.ndarray:
        """Sideways position from the middle, velocity, acceleration (n, 3)."""
        duration = np.full(len(sway.elapsed), self._config.duration)
        goal = np.tile([0.0, self._speed, 0.0], (len(duration), 1))
        late = sway.elapsed > self._config.duration
        result = follow(sway.start, goal, duration, np.minimum(sway.elapsed, duration))
        result[late, 0] += self._speed * (sway.elapsed - duration)[late]
        return result

    def done(self, sway: Sway, offset: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Robots (n,) that are on their way on to the left foot with the energy of the orbit.

        Args:
            sway: their references.
            offset: sideways place of the centre of mass from the left foot (n,) [m], negative.
            velocity: (n, 2) of the centre of mass [m/s].
        """
        energy = lip.orbital_energy(self._omega, np.stack([offset, velocity[:, 1]], axis=-1))
        lack = self._config.tolerance * self._width
        ready = (velocity[:, 1] > 0) & (energy > self.energy - lack)
        calm = np.abs(velocity[:, 0] - self.forward(sway)[:, 1]) < self._config.settle
        return ready & calm & (sway.elapsed > self._config.duration / 2)

    def restart(self, sway: Sway, position: np.ndarray, velocity: np.ndarray) -> None:
        """Sway again, from here (n, 2), (n, 2), where one has not led to the orbit in time."""
        again = sway.elapsed > self._config.duration + self._config.patience
        sway.start[again, 0] = (position - sway.middle)[again, 1]
        sway.start[again, 1] = velocity[again, 1]
        sway.start[again, 2] = 0.0
        sway.centre[again] = 0.0  # first of all come to a stop
        sway.elapsed[again] = 0.0
