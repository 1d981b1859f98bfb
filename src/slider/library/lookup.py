"""Look gaits up by command and phase, thousands at once."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slider.core.arrays import Array, zeros
from slider.library.joint_table import JointTable, at_phase, standing
from slider.library.mesh import aligned, corners, normalise
from slider.library.reader import GaitLibrary
from slider.library.step_times import StepTimes
from slider.robot.names import NUM_CHANNELS, NUM_JOINTS


@dataclass(frozen=True)
class GaitTable:
    """Gaits on all nodes of the mesh of commands, for fast look-up.

    Attributes:
        times: mean duration of a step, and the commands of the mesh.
        reference: (nx, ny, nw, S, 26 + 13) channels and base motion.
    """

    times: StepTimes
    reference: Array

    @classmethod
    def from_library(cls, library: GaitLibrary) -> "GaitTable":
        """Fill every node of the library's mesh of commands."""
        mesh = library.mesh
        values = np.concatenate([library.samples, aligned(library.base)], axis=2)
        reference = np.tensordot(mesh.node_weights, values, axes=1)
        step_time = mesh.node_weights @ library.step_time.mean(axis=1)
        return cls(StepTimes(mesh.vx, mesh.vy, mesh.yaw_rate, step_time), reference)

    @property
    def joints(self) -> JointTable:
        """The joint positions alone."""
        return JointTable(self.times, np.ascontiguousarray(self.reference[..., :NUM_JOINTS]))

    def at(self, command: Array, phase: Array) -> Array:
        """Channels and base motion (N, 39) of commands (N, 3) at phases (N,) in [0, 1).

        Trilinear in the command, linear in time within a step: the velocities jump at touchdown.
        """
        result = at_phase(self.times, self.reference, command, phase)
        normalise(result[:, NUM_CHANNELS:])
        return result

    @cached_property
    def standing(self) -> Array:
        """Channels and base motion (39,) of a robot that stands on both feet, at rest."""
        result = standing(self.times, self.reference)
        result[NUM_JOINTS:NUM_CHANNELS] = 0.0
        result[NUM_CHANNELS + 7 :] = 0.0
        normalise(result[None, NUM_CHANNELS:])
        return result

    def channels(self, command: Array) -> Array:
        """Channels (N, S, 26) of all samples of the walks at commands (N, 3)."""
        samples = self.reference[..., :NUM_CHANNELS]
        return sum(
            (
                weight[:, None, None] * samples[node]
                for node, weight in corners(self.times, command)
            ),
            start=zeros((len(command), *samples.shape[3:]), command),
        )
