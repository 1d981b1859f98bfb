"""Delay between a controller's output and the drives, the same for positions and torques."""

from slider.config.types import Interval
from slider.core.arrays import NUMPY, Array, namespace, put, rows, zeros


class DelayLine:
    """Inputs of N robots, each later by its own whole number of simulation steps.

    Arrays are beside ``like``; an index and its rows are those of ``core.arrays``.

    Attributes:
        steps: delays (N,) in simulation steps.
    """

    def __init__(
        self, delay: Interval, timestep: float, count: int, width: int, like: Array = NUMPY
    ) -> None:
        self._lower, self._upper = round(delay.lower / timestep), round(delay.upper / timestep)
        self.steps = zeros(count, like, namespace(like).int64) + self._lower
        self._past = zeros((count, self._upper, width), like)

    def draw(self, index: Array, uniform: Array) -> None:
        """New delays of robots ``index`` from numbers (N,) in [0, 1)."""
        xp, choices = namespace(uniform), self._upper - self._lower + 1
        later = xp.astype(xp.floor(choices * rows(uniform, index)), xp.int64)
        put(self.steps, index, self._lower + later)

    def fill(self, index: Array, inputs: Array) -> None:
        """What the drives of robots ``index`` do until their first input arrives (n, width)."""
        put(self._past, index, inputs[:, None])

    def pass_on(self, control: Array) -> Array:
        """Delayed inputs (N, S, width) of inputs (N, S, width), one per simulation step."""
        xp, count = namespace(control), control.shape[1]
        line = xp.concat([self._past, control], axis=1)
        self._past[...] = line[:, count:]
        now = xp.arange(count, device=control.device)
        late = self._upper - self.steps[:, None] + now
        return xp.take_along_axis(line, late[:, :, None], axis=1)
