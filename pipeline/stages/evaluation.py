"""Evaluations of a protocol, of the policy and of the baselines, and Table 1."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pipeline.stages.entries import job, only, robot, simulation, without
from slider.artefacts.plan import JobSpec
from slider.config.control import POLICY, POLICY_LABEL, HzdControlConfig
from slider.config.convert import to_dict
from slider.config.evaluation import EvaluationConfig
from slider.config.hzd import enforced_section
from slider.config.schema import Config
from slider.core.errors import UserError
from slider.core.machine import kernels


def evaluations_of(
    config: Config, protocol: EvaluationConfig, made: Mapping[str, JobSpec], note: str = ""
) -> list[JobSpec]:
    """A protocol's evaluations: each controller at each command, or in each case of the profile.

    ``made`` has the jobs ``walking``, ``library`` and ``foot_placement``; ``note`` is added to
    the labels.
    """
    return [
        one
        for controller in protocol.controllers
        for one in _evaluations(config, protocol, controller, made, note)
    ]


def _evaluations(
    config: Config,
    protocol: EvaluationConfig,
    controller: str,
    made: Mapping[str, JobSpec],
    note: str,
) -> Iterator[JobSpec]:
    """One controller at each command, or in each case. Their sections share all other values."""
    settings = without(protocol_section(protocol), "controllers", "speeds")
    section = {"evaluation": settings, **controlled(config, controller, None)}
    inputs = made_of(config, controller, made)
    stage = "evaluation" if controller == POLICY else "baseline"
    name = f"evaluation of {controller}"
    if protocol.profile is None:
        for speed in protocol.speeds:
            label = f"{name} at {speed:.1f} m/s{note}"
            yield job(stage, label, {**section, "speed": speed}, inputs)
        return
    settings["profile"] = without(to_dict(protocol.profile), "rows", "cases")
    for case in protocol.profile.cases:
        label = f"{name} in {case.name}{note}"
        yield job(stage, label, {**section, "case": to_dict(case)}, inputs)


def protocol_section(protocol: EvaluationConfig) -> dict[str, Any]:
    """A protocol without the options that it does not use: new ones leave old recipes alone."""
    return {name: value for name, value in to_dict(protocol).items() if value is not None}


def controlled(config: Config, controller: str, speed: float | None) -> dict[str, Any]:
    """Robot, plant and controller; the policy comes as an input."""
    section = {"controller": controller, "speed": speed}
    if controller == POLICY:
        return section | simulation(config)
    control = config.control[controller]
    if controller in walkers(config):
        section["hzd"] = enforced_section(config.hzd)
    return section | {
        "robot": robot(config),
        "plant": only(to_dict(config.env), "control_period", "physics", "termination"),
        "control": without(to_dict(control), "label"),
        "numerics": kernels(),
    }


def walkers(config: Config) -> dict[str, HzdControlConfig]:
    """Controllers that walk by gaits."""
    return {n: c for n, c in config.control.items() if isinstance(c, HzdControlConfig)}


def check_walkable(
    config: Config, key: str = "evaluation.controllers", controllers: Iterable[str] = ()
) -> None:
    """Gaits of the virtual knee are no motions of the plant: no controller enforces them.

    Raises:
        UserError: ``key`` asks for one of ``controllers``, by default Table 1's, that does.
    """
    names = controllers or config.evaluation.controllers
    found = [name for name in names if name in walkers(config)]
    if found and config.gait.dynamics == "knee":
        raise UserError(
            f"{key}: expected none of the family hzd with gait.dynamics=knee, "
            f"found {', '.join(found)}"
        )


def made_of(
    config: Config, controller: str, made: Mapping[str, JobSpec]
) -> dict[str, list[JobSpec]]:
    """What a controller is made of: a training, the gait library, or nothing."""
    if controller == POLICY:
        return {"walking": [made["walking"]]}
    needed = ("library", "foot_placement") if controller in walkers(config) else ()
    return {name: [made[name]] for name in needed}


def gait_walks(config: Config, made: Mapping[str, JobSpec]) -> dict[str, JobSpec]:
    """Every gait from its own first sample, with the first controller that walks by gaits."""
    for name in walkers(config):
        section = without(controlled(config, name, None), "controller", "speed")
        section |= {"steps": config.hzd.steps}
        inputs = made_of(config, name, made)
        return {"gait_walks": job("gait_walks", "walks of all gaits", section, inputs)}
    return {}


def protocol_jobs(config: Config, made: Mapping[str, JobSpec]) -> dict[str, JobSpec]:
    """Table and figure of each protocol beside Table 1's, which needs none of them.

    They are of constant speeds, of segments of a case, or of cases.
    """
    jobs = {}
    for name, protocol in config.protocols.items():
        section = {
            "name": name,
            "evaluation": protocol_section(protocol),
            "labels": labels(config, protocol.controllers),
        }
        stage = "speeds" if protocol.profile is None else protocol.profile.rows
        inputs = {"evaluations": evaluations_of(config, protocol, made)}
        jobs[name] = job(stage, name, section, inputs)
    return jobs


def labels(config: Config, controllers: Iterable[str]) -> dict[str, str]:
    """What people call some controllers."""
    found = {POLICY: POLICY_LABEL} | {name: c.label for name, c in config.control.items()}
    return {name: found[name] for name in controllers}


def table1(config: Config, evaluations: list[JobSpec]) -> JobSpec:
    """Table 1 from the records of all evaluations.

    A library that a controller was made with also gives the gaits' own sway. A table without one
    (of baselines alone, of a training without library) does not wait for it.
    """
    section = {"labels": labels(config, config.evaluation.controllers)}
    users = [made for item in evaluations for made in (item, *item.inputs.get("walking", ()))]
    libraries = [user.inputs["library"] for user in users if "library" in user.inputs]
    inputs = {"evaluations": evaluations}
    if libraries:
        inputs["library"] = list(libraries[0])
    return job("table1", "table 1", section, inputs)


def velocity_tracking(config: Config, table1: JobSpec) -> JobSpec:
    """Velocity over time at some of Table 1's commands."""
    asked = config.report.tracking_speeds
    shown = [one for one in table1.inputs["evaluations"] if one.section["speed"] in asked]
    section = {
        "speeds": asked,
        "control_period": config.env.control_period,
        "labels": labels(config, config.evaluation.controllers),
    }
    return job("velocity_tracking", "velocity tracking", section, {"evaluations": shown})
