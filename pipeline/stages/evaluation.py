"""Evaluations of a protocol, of the policy and of the baselines, and Table 1."""

from typing import Any

from pipeline.stages.entries import job
from pipeline.stages.sections import only, robot, simulation, without
from slider.core.config.convert import to_dict
from slider.core.config.evaluation import EvaluationConfig
from slider.core.config.schema import Config
from slider.core.plan import JobSpec

POLICY = "policy"
BASELINE_PREFIX = "mpc_wbc_"


def evaluations_of(
    config: Config, protocol: EvaluationConfig, walking: JobSpec, note: str = ""
) -> list[JobSpec]:
    """A protocol's evaluations: each controller at each command, or with the profile.

    ``note`` is added to their labels.
    """
    commands = protocol.commands if protocol.profile is None else [None]
    return [
        evaluation(config, protocol, controller, command, walking, note)
        for controller in protocol.controllers
        for command in commands
    ]


def evaluation(
    config: Config,
    protocol: EvaluationConfig,
    controller: str,
    command: float | None,
    walking: JobSpec,
    note: str = "",
) -> JobSpec:
    """A protocol with one controller at one command."""
    settings = without(protocol_section(protocol), "controllers", "commands")
    section = {"evaluation": settings} | controlled(config, controller, command)
    what = "changing commands" if command is None else f"{command:.1f} m/s"
    label = f"evaluation of {controller} at {what}{note}"
    if controller == POLICY:
        return job("evaluation", label, section, {"walking": [walking]})
    return job("baseline", label, section)


def protocol_section(protocol: EvaluationConfig) -> dict[str, Any]:
    """A protocol without the options that it does not use: new ones leave old recipes alone."""
    return {name: value for name, value in to_dict(protocol).items() if value is not None}


def controlled(config: Config, controller: str, command: float | None) -> dict[str, Any]:
    """Robot, plant and controller; the policy comes as an input."""
    section = {"controller": controller, "command": command}
    if controller == POLICY:
        return section | simulation(config)
    return section | {
        "robot": robot(config),
        "plant": only(to_dict(config.env), "control_period", "physics", "termination"),
        "control": to_dict(getattr(config.control, controller.removeprefix(BASELINE_PREFIX))),
    }


def table1(config: Config, evaluations: list[JobSpec]) -> JobSpec:
    """Table 1 from the records of all evaluations.

    A library that the policy was trained with also gives the gaits' own sway. A table without one
    (of baselines alone, of a training without library) does not wait for it.
    """
    section = {"evaluation": protocol_section(config.evaluation)}
    trainings = [walking for item in evaluations for walking in item.inputs.get("walking", ())]
    inputs = {"evaluations": evaluations}
    if trainings and "library" in trainings[0].inputs:
        inputs["library"] = list(trainings[0].inputs["library"])
    return job("table1", "table 1", section, inputs)
