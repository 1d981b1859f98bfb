"""Typed settings of the independent checks of gaits."""

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class IntegratorConfig:
    """Tolerances of DOP853: relative [-], absolute [rad, rad/s]."""

    relative: float
    absolute: float


@dataclass(frozen=True, config=STRICT)
class RegulatorConfig:
    """Step-to-step foot placement of the replay; see ``slider.verification.regulator``.

    Attributes:
        lateral, forward: shares of the predicted error; the latter at the gait velocities
            ``speeds`` [m/s], linear between.
        reach: greatest change of a foot's place [m].
        settle, fade: phases by which the foot is over its place, errors of the impact are gone.
        descent: speed of a late swing foot [m/s].
    """

    lateral: float
    forward: list[float]
    speeds: list[float]
    reach: float
    settle: float
    fade: float
    descent: float


@dataclass(frozen=True, config=STRICT)
class ReplayConfig:
    """Replay in MuJoCo.

    Attributes:
        steps: length of the walk.
        timestep: of the physics [s].
        substeps: of the physics per control step.
        points: of the table of targets, per step.
        contact: force that counts as a touchdown [N].
        height, tilt: a lower [m] or more tilted [rad] base has fallen.
        patience: step times after which a swing foot that has not landed missed the ground.
    """

    steps: int
    timestep: float
    substeps: int
    points: int
    contact: float
    height: float
    tilt: float
    patience: float
    regulator: RegulatorConfig


@dataclass(frozen=True, config=STRICT)
class CheckConfig:
    """What the checks of a single gait need.

    Attributes:
        perturbation: of roll [rad] and roll rate [rad/s] in the return map's differences.
        points: per step, for the resampling between nodes.
    """

    integrator: IntegratorConfig
    perturbation: float
    points: int
    replay: ReplayConfig


@dataclass(frozen=True, config=STRICT)
class VerificationConfig(CheckConfig):
    """All of the verification.

    Attributes:
        chunk: gaits per job.
        on_failure: ``error`` ends the collecting job, ``report`` only says so in its results.
        reach: velocities further apart than this are no neighbours [m/s].
        bounds: of every quantity of ``slider.verification.quantities``; null where a quantity is
            only reported.
    """

    chunk: int
    on_failure: str
    reach: float
    bounds: dict[str, float | None]
