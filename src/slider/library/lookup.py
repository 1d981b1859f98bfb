"""Tables over velocity and phase, for thousands of robots at once."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slider.core.arrays import Array, asarray, namespace, zeros
from slider.library.mesh import Axes, aligned, corners, normalise
from slider.library.reader import GaitLibrary
from slider.robot.names import NUM_CHANNELS, NUM_JOINTS


@dataclass(frozen=True)
class StepTimes(Axes):
    """Step time (nx, ny, nw) [s] over a grid of velocities."""

    step_time: Array

    @classmethod
    def constant(cls, step_time: float) -> "StepTimes":
        """The same step time [s] at every velocity."""
        return cls(np.zeros(1), np.zeros(1), np.zeros(1), np.full((1, 1, 1), step_time))

    def at(self, velocity: Array) -> Array:
        """Trilinear step times (N,) [s] of velocities (N, 3); outside the grid its border's."""
        result = zeros(len(velocity), velocity)
        for node, weight in corners(self, velocity):
            result += weight * self.step_time[node]
        return result


@dataclass(frozen=True)
class GaitTable:
    """Walks on all nodes of a mesh of velocities, each of S samples, left stance first.

    Attributes:
        times: mean step times.
        values: channels and base motion (nx, ny, nw, S, 26 + 13), or the first 12 channels alone:
            joint positions [rad or m].
    """

    times: StepTimes
    values: Array

    @classmethod
    def from_library(cls, library: GaitLibrary) -> "GaitTable":
        """Fill every node of the library's mesh of velocities."""
        mesh, arrays = library.mesh, library.arrays
        values = np.concatenate([arrays["samples"], aligned(arrays["base"])], axis=2)
        step_time = mesh.node_weights @ arrays["step_time"].mean(axis=1)
        times = StepTimes(mesh.vx, mesh.vy, mesh.yaw_rate, step_time)
        return cls(times, np.tensordot(mesh.node_weights, values, axes=1))

    @property
    def joints(self) -> "GaitTable":
        """The joint positions alone."""
        return GaitTable(self.times, np.ascontiguousarray(self.values[..., :NUM_JOINTS]))

    def at(self, velocity: Array, phase: Array) -> Array:
        """Rows (N, columns) of velocities (N, 3) at phases (N,) in [0, 1).

        Trilinear in the velocity, linear in time within a step: the velocities jump at touchdown.
        """
        result = self._rows(velocity, phase)
        normalise(result[:, NUM_CHANNELS:])
        return result

    def _rows(self, velocity: Array, phase: Array) -> Array:
        samples, columns = self.values.shape[3:]
        xp, per_step = namespace(phase), samples // 2
        step = xp.asarray(phase >= 0.5, dtype=xp.int64)
        position = (2.0 * phase - step) * (per_step - 1)
        node = xp.asarray(position, dtype=xp.int64).clip(0, per_step - 2)
        share, k = (
            position - node,
            step * per_step + node,
        )  # share of the next sample, sample before
        flat = self.values.reshape(-1, columns)
        result = zeros((len(velocity), columns), velocity)
        _, ny, nw = self.times.shape
        for (x, y, yaw_rate), weight in corners(self.times, velocity):
            row = ((x * ny + y) * nw + yaw_rate) * samples + k
            result += (weight * (1 - share))[:, None] * flat[row]
            result += (weight * share)[:, None] * flat[row + 1]
        return result

    @cached_property
    def standing(self) -> Array:
        """Row (columns,) of a robot that stands on both feet, at rest.

        The mean of the two touchdowns of the gait in place (zero velocity), which are reflections
        of each other.
        """
        place, phase = zeros((2, 3), self.values), asarray([0.0, 0.5], self.values)
        result = self._rows(place, phase).mean(axis=0)
        result[NUM_JOINTS:NUM_CHANNELS] = 0.0
        result[NUM_CHANNELS + 7 :] = 0.0
        normalise(result[None, NUM_CHANNELS:])
        return result

    def channels(self, velocity: Array) -> Array:
        """Channels (N, S, 26) of all samples of the walks at velocities (N, 3)."""
        samples = self.values[..., :NUM_CHANNELS]
        result = zeros((len(velocity), *samples.shape[3:]), velocity)
        for node, weight in corners(self.times, velocity):
            result += weight[:, None, None] * samples[node]
        return result
