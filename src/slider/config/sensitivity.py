"""Typed settings of the sensitivity: which parameters of the robot vary, and what is looked at."""

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class SensitivityConfig:
    """Parameters of the robot that vary one at a time, and what is solved and rolled out.

    Attributes:
        change: parameters are multiplied by 1 − change and by 1 + change [-].
        provenance: tags of the parameters that vary.
        parameters: restricts them to these dotted paths below ``robot``; empty for all.
        commands: forward velocities [m/s].
        robots, duration, warm_up: of the rollouts of each changed robot; [s].
        gaits, policy: whether gaits are solved and the policy is rolled out.
    """

    change: float
    provenance: list[str]
    parameters: list[str]
    commands: list[float]
    robots: int
    duration: float
    warm_up: float
    gaits: bool
    policy: bool
