"""A sway in double support from rest into the sideways orbit, with a closed-loop exit."""

import numpy as np

from slider.config.control import EntryConfig, StepConfig
from slider.control.whole_body import references
from slider.control.whole_body.memory import Sway


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
        self._speed = float(references.lateral_end_velocity(omega, step.time, step.width))
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
        """Pendulum from rest with its centre of pressure in ``centre``: (n, 3)."""
        omega, phase = self._omega, self._omega * sway.elapsed
        cosh, sinh = np.cosh(phase), np.sinh(phase)
        unit = np.stack([1 - cosh, -omega * sinh, -(omega**2) * cosh], axis=-1)
        return sway.centre[:, None] * unit

    def _sideways(self, sway: Sway) -> np.ndarray:
        """Quintic to the middle with the orbit's speed there, past its end straight on: (n, 3)."""
        duration = np.full(len(sway.elapsed), self._config.duration)
        goal = np.tile([0.0, self._speed, 0.0], (len(duration), 1))
        late = sway.elapsed > duration
        result = references.quintic(sway.start, goal, duration, np.minimum(sway.elapsed, duration))
        result[late, 0] += self._speed * (sway.elapsed - duration)[late]
        return result

    def done(
        self, sway: Sway, position: np.ndarray, velocity: np.ndarray, foot: np.ndarray
    ) -> np.ndarray:
        """Whether robots can take their first step, or have to (n,).

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
