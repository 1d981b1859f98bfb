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
        return cls(GaitTables(gaits, feedback), constraints, section["reach"])

    @classmethod
    def of(
        cls, section: Mapping[str, Any], inputs: Mapping[str, Sequence[Path]]
    ) -> "EnforcedGaits | None":
        """Of a stage's inputs, where it has any."""
        if "foot_placement" not in inputs:
            return None
        return cls.load(inputs["library"][0], inputs["foot_placement"][0], section["hzd"])


def hzd_controller(
    robot: RobotConfig, config: HzdControlConfig, enforced: EnforcedGaits, period: float
) -> WalkingController:
    """Virtual constraints on a nominal robot, with ticks of ``period`` [s]."""
    around = Surroundings(robot, config, config.descent, period)
    lengths = KneeLengths.of(robot)
    steps = HzdSteps(config, enforced.constraints, enforced.reach, enforced.gaits, lengths, around)
    return WalkingController(around, steps)
