"""Rules of the evaluation protocols: Table 1's and the others."""

from collections.abc import Iterable
from itertools import pairwise

from slider.config.control import POLICY
from slider.config.evaluation import CaseConfig, EvaluationConfig, ProfileConfig
from slider.config.schema import Config
from slider.config.validation.checks import distinct, named, one_of, period, require
from slider.config.validation.env import check_disturbance


def check_protocols(config: Config) -> None:
    """All protocols and their disturbances; that of Table 1 has no profile."""
    named("protocols", config.protocols)
    expected = "none (the commands of Table 1 are constant; see protocols)"
    require(config.evaluation.profile is None, "evaluation.profile", expected, "one")
    for key, protocol in config.evaluations.items():
        _protocol(protocol, (POLICY, *config.control), key, config.env.control_period)
        check_disturbance(protocol.disturbance, config.env, f"{key}.disturbance")


def _protocol(
    protocol: EvaluationConfig, controllers: Iterable[str], key: str, control_period: float
) -> None:
    _commands(protocol, control_period, key)
    for name in protocol.controllers:
        one_of(f"{key}.controllers", name, controllers)
    period(f"{key}.warm_up", protocol.warm_up, protocol.duration, control_period)


def _commands(protocol: EvaluationConfig, control_period: float, key: str) -> None:
    """Either constant ones or a profile."""
    commands, profile = protocol.commands, protocol.profile
    if profile is None:
        require(len(commands) > 0, f"{key}.commands", "at least one command", "none")
        return
    require(not commands, f"{key}.commands", "none with a profile", commands)
    _profile(profile, protocol.duration, control_period, f"{key}.profile")


def _profile(profile: ProfileConfig, duration: float, control_period: float, key: str) -> None:
    names = [case.name for case in profile.cases]
    distinct(f"{key}.cases", names, "each name once")
    possible = profile.rows == "cases" or len(names) == 1
    require(possible, f"{key}.cases", "one case where rows are its segments", names)
    shortest = max(profile.ramp, profile.warm_up) + control_period
    for index, case in enumerate(profile.cases):
        _segments(case, duration, shortest, f"{key}.cases[{index}].segments")


def _segments(case: CaseConfig, duration: float, shortest: float, key: str) -> None:
    distinct(key, [segment.name for segment in case.segments], "each name once")
    times = [segment.time for segment in case.segments]
    require(times[0] == 0.0, f"{key}[0].time", "0 s", times[0])
    for index, (start, end) in enumerate(pairwise(times), start=1):
        require(start < end, f"{key}[{index}].time", f"later than {start:g} s", end)
    expected = f"a control period longer than ramp and warm_up ({shortest:g} s)"
    for index, (start, end) in enumerate(pairwise([*times, duration])):
        length = end - start
        require(length >= shortest - 1e-9, f"{key}[{index}]", expected, f"{length:g} s")
