"""The sensitivity: each assumed parameter of the robot changed, one at a time.

A changed robot has gaits of its own and rollouts of the unchanged policy. All are ordinary jobs: a
parameter that the gaits do not use leaves them the recipes of the unchanged robot's gaits, which
are then solved once.
"""

from collections.abc import Sequence
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


def sensitivity_job(config: Config, walking: JobSpec) -> JobSpec:
    """Gaits and rollouts of all changed robots, and the table of them, for the trained policy."""
    settings, study = config.sensitivity, _Study(config, walking)
    chosen = choose(parameters(config.robot), settings.provenance, settings.parameters)
    nominal = study.made(config.robot)
    factors = [round(1 + sign * settings.change, 10) for sign in (-1, 1)]
    section = {
        "change": settings.change,
        "commands": settings.commands,
        "robots": settings.robots,
        "duration": settings.duration,
        "skipped": [item.path for item in chosen if item.zero],
        "nominal": nominal,
        "variants": [study.row(i, factor) for i in chosen if not i.zero for factor in factors],
    }
    inputs = {"gaits": list(study.gaits.values()), "rollouts": list(study.rollouts.values())}
    return job("sensitivity", "sensitivity", section, inputs)


@dataclass(frozen=True)
class _Study:
    """Jobs of changed robots, each once by its recipe; the first of equal ones stays."""

    config: Config
    walking: JobSpec
    gaits: dict[str, JobSpec] = field(default_factory=dict)
    rollouts: dict[str, JobSpec] = field(default_factory=dict)

    def row(self, parameter: Parameter, factor: float) -> dict[str, Any]:
        """One parameter changed, and the places of its jobs, or why there is no such robot."""
        row: dict[str, Any] = {
            "parameter": parameter.path,
            "provenance": parameter.provenance,
            "unit": parameter.unit,
            "factor": factor,
            "nominal": _text(parameter.value),
            "value": _text([item * factor for item in parameter.value]),
            "note": "",
            "gaits": [],
            "rollout": None,
        }
        try:
            changed = scaled(self.config.robot, parameter.path, factor)
            validate(replace(self.config, robot=changed))
        except UserError as error:
            return row | {"note": f"no such robot: {error}"}
        return row | self.made(changed, f", {parameter.path} × {factor:g}")

    def made(self, changed: RobotConfig, note: str = "") -> dict[str, Any]:
        """Places of a robot's gaits, one per command, and of its rollouts."""
        settings = self.config.sensitivity
        made: dict[str, Any] = {"gaits": [], "rollout": None}
        if settings.gaits:
            shared = gait_section(replace(self.config, robot=changed))
            solved = [gait(shared, (command, 0.0, 0.0)) for command in settings.commands]
            made["gaits"] = [_place(self.gaits, item, note) for item in solved]
        if settings.policy:
            walked = rollout(self.config, changed, self.walking)
            made["rollout"] = _place(self.rollouts, walked, note)
        return made


def _place(jobs: dict[str, JobSpec], made: JobSpec, note: str) -> int:
    """Place of a job among others, called after the parameter that changed."""
    jobs.setdefault(made.recipe, replace(made, label=f"{made.label}{note}"))
    return list(jobs).index(made.recipe)


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


def _text(values: Sequence[float]) -> str:
    """Numbers of a table's cell, those of a vector with blanks between."""
    return " ".join(f"{value:.6g}" for value in values)
