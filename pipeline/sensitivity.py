"""The sensitivity: each assumed parameter of the robot changed, one at a time.

A changed robot has gaits of its own and rollouts of the unchanged policy. All are ordinary jobs: a
parameter that the gaits do not use leaves them the recipes of the unchanged robot's gaits, which
are then solved once.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from pipeline.stages.entries import job
from pipeline.stages.evaluation import protocol_section
from pipeline.stages.gaits import gait, gait_section
from pipeline.stages.sections import simulation, without
from slider.artefacts.plan import JobSpec
from slider.config.control import POLICY
from slider.config.parameters import Parameter, choose, parameters, scaled
from slider.config.robot import RobotConfig
from slider.config.schema import Config
from slider.config.validation import validate
from slider.core.errors import UserError

GAITS_ONLY = ("virtual_knee",)
"""Parts of the robot that only the gait solver knows; the simulated one has none of them."""


@dataclass(frozen=True)
class _Variant:
    """A robot with one parameter changed, or why there is no such robot."""

    parameter: Parameter
    factor: float
    robot: RobotConfig | None
    note: str = ""

    @property
    def label(self) -> str:
        return f"{self.parameter.path} × {self.factor:g}"


@dataclass(frozen=True)
class _Jobs:
    """Jobs, each once."""

    found: dict[str, JobSpec] = field(default_factory=dict)

    def place(self, made: JobSpec) -> int:
        """Place of a job among them; the first of equal ones stays."""
        self.found.setdefault(made.recipe, made)
        return list(self.found).index(made.recipe)


def sensitivity_job(config: Config, walking: JobSpec) -> JobSpec:
    """Gaits and rollouts of all changed robots, and the table of them, for the trained policy."""
    settings = config.sensitivity
    chosen = choose(parameters(config.robot), settings.provenance, settings.parameters)
    gaits, rollouts = _Jobs(), _Jobs()
    nominal = _made(config, config.robot, "", walking, gaits, rollouts)
    rows = []
    for variant in _variants(config, [item for item in chosen if not item.zero]):
        made: dict[str, Any] = {"note": variant.note, "gaits": [], "rollout": None}
        if variant.robot is not None:
            made |= _made(config, variant.robot, variant.label, walking, gaits, rollouts)
        rows.append(_about(variant) | made)
    section = {
        "change": settings.change,
        "commands": settings.commands,
        "robots": settings.robots,
        "duration": settings.duration,
        "skipped": [item.path for item in chosen if item.zero],
        "nominal": nominal,
        "variants": rows,
    }
    inputs = {"gaits": list(gaits.found.values()), "rollouts": list(rollouts.found.values())}
    return job("sensitivity", "sensitivity", section, inputs)


def _variants(config: Config, chosen: Sequence[Parameter]) -> Iterator[_Variant]:
    for parameter in chosen:
        for factor in (1 - config.sensitivity.change, 1 + config.sensitivity.change):
            yield _variant(config, parameter, round(factor, 10))


def _variant(config: Config, parameter: Parameter, factor: float) -> _Variant:
    try:
        changed = scaled(config.robot, parameter.path, factor)
        validate(replace(config, robot=changed))
    except UserError as error:
        return _Variant(parameter, factor, None, f"no such robot: {error}")
    return _Variant(parameter, factor, changed)


def _made(
    config: Config,
    changed: RobotConfig,
    label: str,
    walking: JobSpec,
    gaits: _Jobs,
    rollouts: _Jobs,
) -> dict[str, Any]:
    """Places of a robot's gaits, one per command, and of its rollouts."""
    settings, own = config.sensitivity, replace(config, robot=changed)
    made: dict[str, Any] = {"gaits": [], "rollout": None}
    if settings.gaits:
        shared = gait_section(own)
        solved = [_noted(gait(shared, (command, 0.0, 0.0)), label) for command in settings.commands]
        made["gaits"] = [gaits.place(item) for item in solved]
    if settings.policy:
        made["rollout"] = rollouts.place(_noted(rollout(config, changed, walking), label))
    return made


def rollout(config: Config, changed: RobotConfig, walking: JobSpec) -> JobSpec:
    """The policy on a robot that it was not trained on, at all commands."""
    settings = config.sensitivity
    own = {name: getattr(config.robot, name) for name in GAITS_ONLY}
    protocol = replace(
        config.evaluation,
        trials=1,
        robots=settings.robots,
        duration=settings.duration,
        warm_up=settings.warm_up,
    )
    section = {
        **simulation(replace(config, robot=replace(changed, **own))),
        "evaluation": without(protocol_section(protocol), "controllers", "commands"),
        "controller": POLICY,
        "commands": settings.commands,
    }
    label = "policy on the robot"
    return job("sensitivity_policy", label, section, {"walking": [walking]}, tracked=False)


def _noted(made: JobSpec, label: str) -> JobSpec:
    """The same job, called after the parameter that changed."""
    return replace(made, label=f"{made.label}, {label}") if label else made


def _about(variant: _Variant) -> dict[str, Any]:
    nominal = variant.parameter.value
    return {
        "parameter": variant.parameter.path,
        "provenance": variant.parameter.provenance,
        "unit": variant.parameter.unit,
        "factor": variant.factor,
        "nominal": _text(nominal),
        "value": _text([item * variant.factor for item in nominal]),
    }


def _text(values: Sequence[float]) -> str:
    """Numbers of a table's cell, those of a vector with blanks between."""
    return " ".join(f"{value:.6g}" for value in values)
