"""Joint positions of gaits by command and phase: what an action about the gait needs to know."""

from dataclasses import dataclass
from functools import cached_property

from slider.core.arrays import Array, asarray, namespace, zeros
from slider.library.mesh import corners
from slider.library.step_times import StepTimes


@dataclass(frozen=True)
class JointTable:
    """Joint positions on all nodes of the mesh of commands.

    Attributes:
        times: step times, and the commands of the mesh.
        positions: (nx, ny, nw, S, 12) [rad or m] at S samples per walk, left stance first.
    """

    times: StepTimes
    positions: Array

    def at(self, command: Array, phase: Array) -> Array:
        """Joint positions (N, 12) of commands (N, 3) at phases (N,) in [0, 1)."""
        return at_phase(self.times, self.positions, command, phase)

    @cached_property
    def standing(self) -> Array:
        """Joint positions (12,) on both feet at rest: see :func:`standing`."""
        return standing(self.times, self.positions)


def standing(times: StepTimes, table: Array) -> Array:
    """Row (channels,) of a table (nx, ny, nw, S, channels) for standing on both feet.

    The mean of the two changes of feet of the gait in place, which are reflections of each other.
    """
    place, phase = zeros((2, 3), table), asarray([0.0, 0.5], table)
    return at_phase(times, table, place, phase).mean(axis=0)


def at_phase(times: StepTimes, table: Array, command: Array, phase: Array) -> Array:
    """Rows (N, channels) of a table (nx, ny, nw, S, channels) at commands (N, 3), phases (N,).

    Trilinear in the command, linear in time within a step: the velocities jump at touchdown.
    """
    samples, channels = table.shape[3:]
    k, c = _sample(phase, samples)
    flat = table.reshape(-1, channels)
    result = zeros((len(command), channels), command)
    _, ny, nw = times.shape
    for (x, y, yaw_rate), weight in corners(times, command):
        row = ((x * ny + y) * nw + yaw_rate) * samples + k
        result += (weight * (1 - c))[:, None] * flat[row]
        result += (weight * c)[:, None] * flat[row + 1]
    return result


def _sample(phase: Array, samples: int) -> tuple[Array, Array]:
    """Index of the sample before a phase, and the fraction of the way to the next."""
    per_step = samples // 2
    xp = namespace(phase)
    step = xp.asarray(phase >= 0.5, dtype=xp.int64)
    position = (2.0 * phase - step) * (per_step - 1)
    node = xp.asarray(position, dtype=xp.int64).clip(0, per_step - 2)
    return step * per_step + node, position - node
