"""A gait as a table over time, for the replay: joints, efforts, centre of mass, swing foot."""

# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass
from itertools import pairwise

import mujoco
import numpy as np

from slider.robot import names
from slider.verification.plant import Plant, PlantState
from slider.verification.stored import StoredGait

_BASE = 6


@dataclass(frozen=True)
class StepReference:
    """N points of a step on the prismatic robot, relative to the stance foot, world axes.

    Attributes:
        side: the stance foot's.
        duration: [s].
        table: (N, 12 + 12 + 12 + 3 + 3 + 3 + 3 + 2) joints, velocities, efforts, centre of mass
            [m] and its velocity [m/s], sole of the swing foot [m], direction of its line, sines
            of the base's roll and pitch.
    """

    side: str
    duration: float
    table: np.ndarray

    def at(self, time: float) -> "Reference":
        """Linear interpolation; before the start and after the end the outermost points hold."""
        place = min(max(time / self.duration, 0.0), 1.0) * (len(self.table) - 1)
        k = min(int(place), len(self.table) - 2)
        row = self.table[k] + (place - k) * (self.table[k + 1] - self.table[k])
        return Reference(*(row[part] for part in _PARTS))


_ENDS = np.cumsum([0] + [names.NUM_JOINTS] * 3 + [3, 3, 3, 3, 2])
_PARTS = [slice(start, end) for start, end in pairwise(_ENDS)]


@dataclass(frozen=True)
class Reference:
    """One row of the table."""

    joints: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray
    com: np.ndarray
    com_velocity: np.ndarray
    swing: np.ndarray
    direction: np.ndarray
    tilt: np.ndarray


def tabulate(gait: StoredGait, plant: Plant, points: int) -> tuple[StepReference, StepReference]:
    """Both steps of a gait after eq. 1 (exact), with the plant's own efforts.

    The ground wrench is the one that balances the base, but for a moment about the foot line,
    which the line cannot carry; of a gait with the prismatic leg's dynamics it is the gait's.
    """
    steps = []
    for motion in gait.steps:
        times = np.linspace(0.0, motion.duration, points)
        rows = [_row(plant, plant.moving(motion, time), motion.side) for time in times]
        steps.append(StepReference(motion.side, motion.duration, np.array(rows)))
    return steps[0], steps[1]


def _row(plant: Plant, state: PlantState, side: str) -> np.ndarray:
    efforts, _ = plant.balanced(state, side)
    data, model = plant.data, plant.model
    mujoco.mj_subtreeVel(model, data)
    base = model.body(names.BASE).id
    other = names.SIDES[1 - names.SIDES.index(side)]
    foot = data.site(names.sole(other))
    direction = foot.xmat.reshape(3, 3)[:, 0]
    joints, velocities = state.qpos[7:], state.qvel[_BASE:]
    return np.concatenate(
        [joints, velocities, efforts, data.subtree_com[base], data.subtree_linvel[base]]
        + [foot.xpos, direction, tilt_of(data.xmat[base].reshape(3, 3))]
    )


def tilt_of(rotation: np.ndarray) -> np.ndarray:
    """Sines of roll and pitch (2,) of a rotation (3, 3) to world."""
    return np.array([rotation[2, 1], -rotation[2, 0]])
