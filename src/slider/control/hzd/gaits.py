"""Gaits to be enforced, blended for the velocities of many robots at once.

Everything is in the frame of the stance foot, reflected in right stance, so that left and right
steps have the same form.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.hzd import VirtualConstraintsConfig
from slider.control.hzd.motion import side_of
from slider.core.errors import UserError
from slider.hzd.constraints import NodeTable, StepConstraints, Steps
from slider.hzd.foot_placement import FootPlacement
from slider.library.mesh import VelocityMesh
from slider.library.reader import STORE, GaitLibrary
from slider.robot.knee_map import KneeLengths
from slider.robot.names import SIDES


@dataclass
class EnforcedSteps:
    """Current steps of n robots along their gaits; S phases.

    Attributes:
        constraints: virtual constraints of the steps.
        duration: (n,) [s].
        turn: change of the course over the step (n,) [rad].
        hip: forward position of the hip relative to the stance foot (m = 1) [m].
        gains: K (n, 2, S, 2, 4) of :class:`FootPlacement`, by time and by the hip.
        orbit: ξ* (n, S, 4).
        by_hip: whether the phase follows from the hip's position, not from time.
        phase, rate: of the steps [1], [1/s].
        line: yaw of the stance foot in the gait (n,) [rad].
        footholds: of the stance foot, and of the swing foot before and (without its displacement)
            after the step (n, 3, 2) [m], world.
    """

    constraints: StepConstraints
    duration: np.ndarray
    turn: np.ndarray
    hip: NodeTable
    gains: np.ndarray
    orbit: np.ndarray
    by_hip: np.ndarray
    phase: np.ndarray
    rate: np.ndarray
    line: np.ndarray
    footholds: np.ndarray


class EnforcedGaits:
    """Gaits of a library, the virtual constraints to enforce, and step-to-step feedback.

    ``reach`` is the largest displacement of a foothold [m].

    Raises:
        UserError: library and foot placement have different gaits.
    """

    def __init__(
        self,
        library: GaitLibrary,
        feedback: FootPlacement,
        constraints: VirtualConstraintsConfig,
        reach: float,
    ) -> None:
        if not np.array_equal(library.velocities, feedback.velocities):
            raise UserError(
                f"expected the foot placement of {len(library)} gaits, "
                f"found one of {len(feedback.velocities)} others"
            )
        self.constraints, self.reach = constraints, reach
        self._legs = KneeLengths.of(library.robot), library.robot.geometry.slide_length
        self._mesh = VelocityMesh.of(library.velocities)
        step_time, coefficients = library.arrays["step_time"], library.arrays["coefficients"]
        time = step_time[:, :, None, None]
        roll = library.arrays["roll"] * np.concatenate([time**k for k in range(3)], axis=3)
        gains = feedback.gains.swapaxes(1, 2)  # steps come first
        parts = [step_time, coefficients, roll, feedback.hip, gains]
        parts += [feedback.orbit, feedback.placement]
        self._shapes = [part.shape[2:] for part in parts]
        flat = [part.reshape(len(part), len(SIDES), -1) for part in parts]
        self._ends = np.cumsum([part.shape[2] for part in flat])
        self._table = np.concatenate(flat, axis=2).swapaxes(0, 1)  # (2, G, values)

    def at(self, velocities: np.ndarray, stance: np.ndarray) -> EnforcedSteps:
        """New steps, stance feet ``stance`` (n,), at velocities (n, 3); rows independent of n."""
        values = np.empty((len(stance), self._table.shape[2]))
        for row, weights in enumerate(self._mesh.weights(velocities)):
            near = np.flatnonzero(weights)
            values[row] = weights[near] @ self._table[stance[row], near]
        split = np.split(values, self._ends[:-1], axis=1)
        parts = [v.reshape(len(stance), *s) for v, s in zip(split, self._shapes, strict=True)]
        times, coefficients, *tables, gains, orbit, placement = parts
        roll, hip = (NodeTable(*(table[:, :, k, None] for k in range(3))) for table in tables)
        # Even if no gait turns that fast, the foot points along the course in mid-step.
        turns = velocities[:, 2] * times * side_of(stance)
        by_hip = velocities[:, 0] >= self.constraints.slowest_hip
        steps = Steps(coefficients, roll, placement, *self._legs).constraints(self.constraints)
        phase, line = np.zeros((2, len(stance)))
        state = by_hip, phase, 1.0 / times, line, np.zeros((len(stance), 3, 2))
        return EnforcedSteps(steps, times, turns, hip, gains, orbit, *state)

    @classmethod
    def load(cls, library: Path, placement: Path, section: Mapping[str, Any]) -> "EnforcedGaits":
        """Read the folders of a library and of its foot placement.

        Raises:
            UserError: they do not belong together.
        """
        gaits, feedback = GaitLibrary.load(library / STORE), FootPlacement.load(placement)
        constraints = from_dict(VirtualConstraintsConfig, section["constraints"])
        if not np.array_equal(feedback.clock, gaits.velocities[:, 0] < constraints.slowest_hip):
            expected = f"expected foot placement for hzd.slowest_hip={constraints.slowest_hip:g}"
            raise UserError(f"{expected}, found that of other phases")
        return cls(gaits, feedback, constraints, section["reach"])


def at_phase(table: np.ndarray, phase: np.ndarray, *indices: np.ndarray) -> np.ndarray:
    """Interpolate a table (n, S, …) linearly over equally spaced phases, clamped: (n, …).

    A larger table (n, …, S, …) is read at ``indices``, each (n,), of the axes between n and S.
    """
    robots = np.arange(len(phase)), *indices
    last = table.shape[len(robots)] - 1
    place = np.clip(phase, 0.0, 1.0) * last
    left = np.minimum(place.astype(int), last - 1)
    here, ahead = table[*robots, left], table[*robots, left + 1]
    return here + (place - left).reshape(-1, *(1,) * (here.ndim - 1)) * (ahead - here)
