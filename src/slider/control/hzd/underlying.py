"""The controller ``hzd`` under the actions of a policy: from a stage's inputs or a policy file."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import torch

from slider.config.control import HzdControlConfig
from slider.config.convert import from_dict, to_dict
from slider.config.hzd import VirtualConstraintsConfig
from slider.config.robot import RobotConfig
from slider.control.hzd.controller import EnforcedGaits, HzdController, hzd_controller
from slider.control.hzd.gaits import GaitTables


def underlying_of(content: Mapping[str, Any] | None) -> "UnderlyingHzd | None":
    """What a policy file has of it, if it has any."""
    return None if content is None else UnderlyingHzd.from_plain(content)


@dataclass(frozen=True)
class UnderlyingHzd:
    """What the controller is made of; see :class:`slider.env.underlying.Underlying`.

    Attributes:
        config: its settings.
        enforced: gaits, constraints and foot placement.
    """

    config: HzdControlConfig
    enforced: EnforcedGaits

    @classmethod
    def of(
        cls, section: Mapping[str, Any], inputs: Mapping[str, Sequence[Path]]
    ) -> "UnderlyingHzd":
        """Of a stage's section and inputs."""
        config = from_dict(HzdControlConfig, section["control"])
        (library,), (placement,) = inputs["library"], inputs["foot_placement"]
        return cls(config, EnforcedGaits.load(library, placement, section["hzd"]))

    @classmethod
    def from_plain(cls, content: Mapping[str, Any]) -> "UnderlyingHzd":
        """What ``plain`` gave."""
        arrays = {name: tensor.numpy() for name, tensor in content["gaits"].items()}
        constraints = from_dict(VirtualConstraintsConfig, content["constraints"])
        enforced = EnforcedGaits(GaitTables(arrays), constraints, content["reach"])
        return cls(from_dict(HzdControlConfig, content["control"]), enforced)

    def plain(self) -> dict[str, Any]:
        """Numbers, texts and tensors."""
        enforced = self.enforced
        return {
            "control": to_dict(self.config),
            "constraints": asdict(enforced.constraints),
            "reach": enforced.reach,
            "gaits": {n: torch.from_numpy(array) for n, array in enforced.gaits.arrays.items()},
        }

    @property
    def substeps(self) -> int:
        """Simulation steps per tick."""
        return self.config.substeps

    def controller(self, robot: RobotConfig, period: float) -> HzdController:
        """A controller with ticks of ``period`` [s]."""
        return hzd_controller(robot, self.config, self.enforced, period)
