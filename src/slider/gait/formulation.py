"""What a gait is, the same for all commanded velocities: a robot, its dynamics and settings.

Two steps make a walk. The second is written in reflected coordinates, so that the stance foot is
always the left one and the same functions serve both. A turning walk's course has the commanded
yaw rate ω: in a step of duration T it goes from −ω T/2 to ω T/2 against the stance foot's line,
and the next foot lands yawed by ω T. In the reflected step ω has the other sign.
"""

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from slider.config.gait import FormulationConfig
from slider.config.robot import Mechanism, leg_scale
from slider.gait.dynamics import PrismaticTree, StanceTree
from slider.robot.bodies import knee_bodies, total_mass
from slider.robot.names import GRAVITY


@dataclass(frozen=True)
class Formulation:
    """What ``slider.gait.constraints`` are about.

    Attributes:
        tree: kinematics and dynamics of the robot on its left foot.
        config, robot: settings, and the limits of the robot.
        turning: whether the velocities have a yaw rate; else it is zero in all expressions.
        hip_rate: least forward velocity of the hip [m/s], where it is the phase.
    """

    tree: StanceTree
    config: FormulationConfig
    robot: Mechanism
    turning: bool = False
    hip_rate: float = -np.inf

    @property
    def by_hip(self) -> bool:
        """Whether the hip is the phase, and drives it."""
        return self.config.phase == "hip" and self.hip_rate > 0

    @property
    def facts(self) -> list[Any]:
        """All that its functions depend on; the hip's least rate is a bound."""
        return [asdict(self.robot), asdict(self.config), self.turning, self.by_hip]

    @cached_property
    def weight(self) -> float:
        """m g [N]."""
        return total_mass(knee_bodies(self.robot)) * GRAVITY

    @property
    def leg_scale(self) -> float:
        """Leg length as a multiple of SLIDER's."""
        return leg_scale(self.robot.geometry.leg_length)

    @property
    def foot_ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Toe and heel in the foot frame (3,) [m]."""
        geometry, sole = self.robot.geometry, self.tree.sole
        return sole + [geometry.toe, 0.0, 0.0], sole - [geometry.heel, 0.0, 0.0]


def least_hip_rate(config: FormulationConfig, vx: float) -> float:
    """Bound of the hip's forward velocity [m/s] in gaits with ``vx`` [m/s]; slow ones have none."""
    return config.hip_share * vx if vx >= config.slowest_hip else -np.inf


def formulate(
    robot: Mechanism, config: FormulationConfig, turning: bool = False, hip_rate: float = -np.inf
) -> Formulation:
    """The formulation with the configured dynamics: the prismatic leg's or the virtual knee's."""
    tree = StanceTree(robot) if config.dynamics == "knee" else PrismaticTree(robot)
    return Formulation(tree, config, robot, turning, hip_rate)
