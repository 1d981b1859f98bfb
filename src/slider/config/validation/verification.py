"""Checks of the settings of the gaits' independent checks."""

from slider.config.validation.checks import all_positive, at_least, one_of, positive, require
from slider.config.verification import RegulatorConfig, ReplayConfig, VerificationConfig


def check_verification(verification: VerificationConfig) -> None:
    """Chunks, differences, integrator and replay."""
    key = "verification"
    at_least(f"{key}.chunk", verification.chunk, 1)
    one_of(f"{key}.on_failure", verification.on_failure, ("error", "report"))
    at_least(f"{key}.points", verification.points, 2)
    names = ("reach", "perturbation", "integrator.relative", "integrator.absolute")
    all_positive(key, verification, names)
    _replay(verification.replay, f"{key}.replay")


def _replay(replay: ReplayConfig, key: str) -> None:
    at_least(f"{key}.steps", replay.steps, 1)
    _shares(replay.regulator, f"{key}.regulator.forward")
    at_least(f"{key}.points", replay.points, 2)
    at_least(f"{key}.substeps", replay.substeps, 1)
    positive(f"{key}.timestep", replay.timestep)
    all_positive(key, replay, ("regulator.settle", "regulator.fade"))


def _shares(regulator: RegulatorConfig, key: str) -> None:
    shares, speeds = regulator.forward, regulator.speeds
    possible = len(shares) == len(speeds) > 0 and speeds == sorted(speeds)
    expected = "one share for each of the rising `speeds`"
    require(possible, key, expected, f"{shares} at {speeds}")
