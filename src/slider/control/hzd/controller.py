"""The controller ``hzd``: gaits of the library, enforced by input-output linearisation as a QP."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.control import HzdControlConfig
from slider.config.convert import from_dict
from slider.config.hzd import VirtualConstraintsConfig
from slider.config.robot import RobotConfig
from slider.control.hzd.gaits import GaitTables
from slider.control.hzd.steps import HzdSteps
from slider.control.whole_body.controller import Surroundings, WalkingController
from slider.control.whole_body.memory import RIGHT, WALK
from slider.core.errors import UserError
from slider.hzd.gains import FootPlacement
from slider.library.reader import STORE, GaitLibrary
from slider.robot.knee_map import KneeLengths


@dataclass(frozen=True)
class EnforcedGaits:
    """Gaits, what is enforced of them, and the feedback from step to step.

    Attributes:
        gaits: with their foot placement.
        constraints: outputs and their phase.
        reach: largest displacement of a foothold [m].
    """

    gaits: GaitTables
    constraints: VirtualConstraintsConfig
    reach: float

    @classmethod
    def load(cls, library: Path, placement: Path, section: Mapping[str, Any]) -> "EnforcedGaits":
        """Of the folders of a library and its foot placement.

        Raises:
            UserError: they do not belong together.
        """
        gaits, feedback = GaitLibrary.load(library / STORE), FootPlacement.load(placement)
        constraints = from_dict(VirtualConstraintsConfig, section["constraints"])
        slow = gaits.commands[:, 0] < constraints.slowest_hip
        if not np.array_equal(feedback.clock, slow | (constraints.phase == "time")):
            expected = f"hzd.phase={constraints.phase}, hzd.slowest_hip={constraints.slowest_hip:g}"
            raise UserError(f"expected foot placement for {expected}, found that of other phases")
        return cls(GaitTables.of(gaits, feedback), constraints, section["reach"])

    @classmethod
    def of(
        cls, section: Mapping[str, Any], inputs: Mapping[str, Sequence[Path]]
    ) -> "EnforcedGaits | None":
        """Of a stage's inputs, where it has any."""
        if "foot_placement" not in inputs:
            return None
        return cls.load(inputs["library"][0], inputs["foot_placement"][0], section["hzd"])


_LAST = 1.0 - 1e-9  # phase of a step that is late: it is not the next one yet


class HzdController(WalkingController):
    """Torques of N robots by virtual constraints.

    Args:
        around: the robot, its entry and its body.
        steps: by the gaits.
    """

    def __init__(self, around: Surroundings, steps: HzdSteps) -> None:
        super().__init__(around, steps)
        self._steps = steps

    @property
    def halted(self) -> np.ndarray:
        """Whether a robot makes no steps (N,): it sways, stands or is switched off."""
        return self.memory.mode != WALK

    @property
    def phase(self) -> np.ndarray:
        """Of the walk (N,) in [0, 1): left stance below 0.5; halted, of the next foot."""
        memory, halted = self.memory, self.halted
        right = np.where(halted, memory.sway.side < 0, memory.stance == RIGHT)
        return 0.5 * (right + np.where(halted, 0.0, np.clip(self._steps.phase, 0.0, _LAST)))


def hzd_controller(
    robot: RobotConfig, config: HzdControlConfig, enforced: EnforcedGaits, period: float
) -> HzdController:
    """Virtual constraints on a nominal robot, with ticks of ``period`` [s]."""
    around = Surroundings(robot, config, config.descent, period)
    lengths = KneeLengths.of(robot)
    steps = HzdSteps(config, enforced.constraints, enforced.reach, enforced.gaits, lengths, around)
    return HzdController(around, steps)
