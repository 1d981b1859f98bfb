"""Joint positions of gaits by command and phase: what an action about the gait needs to know."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slider.library.mesh import corners
from slider.library.step_times import StepTimes


@dataclass(frozen=True)
class JointTable:
    """Joint positions on all nodes of the mesh of velocities.

    Attributes:
        times: step times, and the velocities of the mesh.
        positions: (nx, ny, S, 12) [rad or m] at S samples per walk, left stance first.
    """

    times: StepTimes
    positions: np.ndarray

    def at(self, vx: np.ndarray, vy: np.ndarray, phase: np.ndarray) -> np.ndarray:
        """Joint positions (N, 12) of commands (N,), (N,) [m/s] at phases (N,) in [0, 1)."""
        return at_phase(self.times, self.positions, vx, vy, phase)

    @cached_property
    def standing(self) -> np.ndarray:
        """Joint positions (12,) on both feet at rest: see :func:`standing`."""
        return standing(self.times, self.positions)


def standing(times: StepTimes, table: np.ndarray) -> np.ndarray:
    """Row (channels,) of a table (nx, ny, S, channels) for standing on both feet.

    The mean of the two changes of feet of the gait in place, which are reflections of each other.
    """
    zero = np.zeros(2)
    return at_phase(times, table, zero, zero, np.array([0.0, 0.5])).mean(axis=0)


def at_phase(
    times: StepTimes, table: np.ndarray, vx: np.ndarray, vy: np.ndarray, phase: np.ndarray
) -> np.ndarray:
    """Rows (N, channels) of a table (nx, ny, S, channels) at commands and phases (N,).

    Bilinear in velocity, linear in time within a step: the velocities jump at touchdown.
    """
    k, c = _sample(phase, table.shape[2])
    flat = table.reshape(-1, table.shape[3])
    result = np.zeros((len(vx), table.shape[3]))
    for i, j, weight in corners(times.vx, times.vy, vx, vy):
        row = (i * table.shape[1] + j) * table.shape[2] + k
        result += (weight * (1 - c))[:, None] * flat[row]
        result += (weight * c)[:, None] * flat[row + 1]
    return result


def _sample(phase: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Index of the sample before a phase, and the fraction of the way to the next."""
    per_step = samples // 2
    step = (phase >= 0.5).astype(int)
    position = (2.0 * phase - step) * (per_step - 1)
    node = np.clip(position.astype(int), 0, per_step - 2)
    return step * per_step + node, position - node
