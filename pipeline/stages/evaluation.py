"""Evaluations of a protocol and of the gauge, of policies and baselines; their tables."""

import importlib.util
import math
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from pipeline.stages.entries import job, only, robot, simulation, without
from slider.artefacts.plan import JobSpec
from slider.config.control import ONBOARD, POLICY, POLICY_LABEL, HzdControlConfig
from slider.config.convert import to_dict
from slider.config.evaluation import EvaluationConfig, GaugeProtocol
from slider.config.hzd import enforced_section
from slider.config.schema import Config
from slider.control import LAYOUT, ONNX
from slider.core.errors import require
from slider.core.files import digest_file
from slider.core.machine import kernels

_EXPORTED = (ONNX, LAYOUT)  # files of an exported policy
# Settings of searches that are not part of an evaluation.
_SEARCH = ("trials", "sampler_seed", "finalists", "finalist_robots", "speeds")


def lay_out(
    config: Config,
    stage: str,
    what: str,
    controllers: Iterable[str],
    cases: Mapping[str, Mapping[str, Any]],
    jobs: Mapping[str, JobSpec],
    tracked: bool = True,
) -> list[JobSpec]:
    """A job per controller and case, labelled ``WHAT of CONTROLLERCASE``, with the case's settings.

    Controllers may need the ``jobs`` ``walking``, ``library`` and ``foot_placement``.
    """
    made = []
    for controller in controllers:
        section, inputs = controlled(config, controller, jobs)
        for case, own in cases.items():
            label = f"{what} of {controller}{case}"
            made.append(job(stage, label, {**section, **own}, inputs, tracked))
    return made


def evaluations_of(
    config: Config, protocol: EvaluationConfig, jobs: Mapping[str, JobSpec], note: str = ""
) -> list[JobSpec]:
    """Evaluations of a protocol, one job per controller and case; ``note`` ends the labels."""
    settings, place = without(protocol_section(protocol), "controllers", "speeds"), "at"
    if protocol.profile is not None:
        settings["profile"], place = without(to_dict(protocol.profile), "rows", "cases"), "in"
    cases = {
        f" {place} {case.name}{note}": {"evaluation": settings, "case": to_dict(case)}
        for case in protocol.cases
    }
    made = []
    for controller in protocol.controllers:
        stage = "evaluation" if base_of(controller) == POLICY else "baseline"
        made += lay_out(config, stage, "evaluation", [controller], cases, jobs)
    return made


def speed_of(evaluation: JobSpec) -> float:
    """Commanded forward velocity of an evaluation at constant velocity [m/s]."""
    return evaluation.section["case"]["segments"][0]["vx"]


def protocol_section(protocol: EvaluationConfig) -> dict[str, Any]:
    """A protocol without unused options, so that new options do not change old recipes."""
    return {name: value for name, value in to_dict(protocol).items() if value is not None}


def controlled(
    config: Config, controller: str, jobs: Mapping[str, JobSpec]
) -> tuple[dict[str, Any], dict[str, list[JobSpec]]]:
    """Section with robot, plant and controller; inputs: a policy, the gait library or nothing."""
    section, base = {"controller": controller}, base_of(controller)
    sensing = "true_state" if base == controller else "onboard"  # env.sensing is for trainings
    config = replace(config, env=replace(config.env, sensing=sensing))
    if base == POLICY:
        return section | simulation(config), {"walking": [jobs["walking"]]}
    if base in config.gauge.policies:
        policy = _import(config.gauge.policies[base], base)
        return section | simulation(config), {"policy": [policy]}
    section |= {
        "robot": robot(config),
        "plant": to_dict(config.env.plant),
        "control": without(to_dict(config.control[base]), "label"),
        "numerics": kernels(),
    }
    if base not in gait_controllers(config):
        return section, {}
    section["hzd"] = enforced_section(config.hzd)
    return section, {name: [jobs[name]] for name in ("library", "foot_placement")}


def base_of(controller: str) -> str:
    """Name of the controller without the suffix for onboard state estimation."""
    return controller.removesuffix(ONBOARD)


def gait_controllers(config: Config) -> list[str]:
    """Controllers that track gaits of the library."""
    return [name for name, c in config.control.items() if isinstance(c, HzdControlConfig)]


def check_walkable(config: Config, key: str, controllers: Iterable[str]) -> None:
    """Check that controllers can track the gaits, which must not be of the virtual knee's dynamics.

    Raises:
        UserError: a controller cannot; the message names it.
    """
    for name in set(map(base_of, controllers)).intersection(gait_controllers(config)):
        expected = "none of the family hzd with gait.dynamics=knee"
        require(config.gait.dynamics != "knee", key, expected, name)


def gait_walks(config: Config, jobs: Mapping[str, JobSpec]) -> dict[str, JobSpec]:
    """Walks of all gaits, each from its first sample, with ``hzd`` or another of its family."""
    for name in sorted(gait_controllers(config), key=lambda name: name != "hzd")[:1]:
        section, inputs = controlled(config, name, jobs)
        section = without(section, "controller") | {"steps": config.hzd.steps}
        return {"gait_walks": job("gait_walks", "walks of all gaits", section, inputs)}
    return {}


def protocol_jobs(config: Config, jobs: Mapping[str, JobSpec]) -> dict[str, JobSpec]:
    """Table and figure per protocol other than Table 1's; rows are speeds, segments or cases."""
    protocols = {}
    for name, protocol in config.protocols.items():
        section = {"name": name, "evaluation": protocol_section(protocol)}
        section |= titles(config, protocol.controllers)
        stage = "speeds" if protocol.profile is None else protocol.profile.rows
        inputs = {"evaluations": evaluations_of(config, protocol, jobs)}
        protocols[name] = job(stage, name, section, inputs)
    return protocols


def titles(config: Config, controllers: Iterable[str]) -> dict[str, Any]:
    """Names of controllers and robot in tables and figures."""
    return {"labels": labels(config, controllers), "robot": config.robot.name}


def labels(config: Config, controllers: Iterable[str]) -> dict[str, str]:
    """Names of controllers in tables and figures.

    Raises:
        UserError: two controllers have the same name.
    """
    texts = {POLICY: POLICY_LABEL} | {name: c.label for name, c in config.control.items()}
    texts |= {name: name for name in config.gauge.policies}
    texts |= {f"{name}{ONBOARD}": f"{text}, onboard state" for name, text in texts.items()}
    chosen = {name: texts[name] for name in controllers}
    for name, text in chosen.items():
        mine = [other for other in chosen if chosen[other] == text]
        require(mine == [name], f"control.{base_of(name)}.label", "a unique label", text)
    return chosen


def table1(config: Config, evaluations: list[JobSpec]) -> JobSpec:
    """Table 1 from all evaluations, and the library of the gaits whose sway it compares, if any."""
    inputs = {"evaluations": evaluations}
    for user in (user for item in evaluations for user in (item, *item.inputs.get("walking", ()))):
        if "library" in user.inputs:
            inputs.setdefault("library", list(user.inputs["library"]))
    return job("table1", "table 1", titles(config, config.evaluation.controllers), inputs)


def baseline_tuning(config: Config, jobs: Mapping[str, JobSpec]) -> JobSpec:
    """Hyperparameter searches of the controllers in ``tuning.spaces``, in one table."""
    check_walkable(config, "tuning.spaces", config.tuning.spaces)
    tuning, values, searches = config.tuning, to_dict(config.tuning), []
    protocol = replace(config.evaluation, trials=1, robots=tuning.robots, seed=tuning.seed)
    evaluation = without(protocol_section(protocol), "controllers", "speeds", "profile")
    for name, space in values["spaces"].items():
        own = only(values, *_SEARCH) | {"evaluation": evaluation, "space": space}
        searches += lay_out(config, "tuning", "search for settings", [name], {"": own}, jobs)
    section = titles(config, tuning.spaces) | {"spaces": values["spaces"]}
    return job("baseline_tuning", "tuned baselines", section, {"searches": searches})


def velocity_tracking(config: Config, table1: JobSpec) -> JobSpec:
    """Plot of the velocity over time at some speeds of Table 1."""
    speeds = config.report.tracking_speeds
    shown = [item for item in table1.inputs["evaluations"] if speed_of(item) in speeds]
    section = {"speeds": speeds, "control_period": config.env.control_period}
    section |= titles(config, config.evaluation.controllers)
    return job("velocity_tracking", "velocity tracking", section, {"evaluations": shown})


def second_engine(config: Config, jobs: Mapping[str, JobSpec]) -> JobSpec:
    """Comparison of both engines, with the audit of Drake's model and the evaluations in both.

    Raises:
        UserError: Drake is not installed, feet have soles, or a controller cannot track the gaits.
    """
    there, settings = importlib.util.find_spec("pydrake") is not None, config.second_engine
    require(there, "second_engine", "Drake (pip install -e '.[drake]' -c constraints.txt)", "none")
    line_feet = config.robot.geometry.sole is None
    require(line_feet, "second_engine", "a robot with line feet", "one with soles")
    check_walkable(config, "second_engine.protocol.controllers", settings.protocol.controllers)
    names, usual = settings.friction_controllers, config.robot.contact.friction
    slippery = replace(settings.protocol, controllers=names, speeds=[settings.friction_speed])
    model = {"robot": robot(config), "physics": to_dict(config.env.physics)}
    audits, rows, evaluations = {}, [], []
    for contact in settings.contacts:
        section = model | {"drake": {"timestep": settings.timestep, "contact": to_dict(contact)}}
        label, name = f"audit of Drake's model, {contact.label}", f"Drake, {contact.label}"
        audits[name] = job("drake_audit", label, section, tracked=False)
    for friction in (usual, *settings.frictions):
        protocol = settings.protocol if friction == usual else slippery
        contact = replace(config.robot.contact, friction=friction)
        there = replace(config, robot=replace(config.robot, contact=contact))
        for one in evaluations_of(there, protocol, jobs, f", friction {friction:g}"):
            made = {"MuJoCo": one}
            for name, audit in audits.items():  # the audit runs before the evaluations
                section = {**one.section, "drake": audit.section["drake"]}
                inputs = {**one.inputs, "audit": [audit]}
                made[name] = job("drake_evaluation", f"{one.label}, {name}", section, inputs)
            rows += [(name, friction) for name in made]
            evaluations += made.values()
    section = titles(config, settings.protocol.controllers)
    section |= {"engines": rows, "friction": usual, "protocol": to_dict(settings.protocol)}
    inputs = {"evaluations": evaluations, "audits": list(audits.values())}
    return job("second_engine", "second engine", section, inputs)


def gauge_job(config: Config, jobs: Mapping[str, JobSpec]) -> JobSpec:
    """Comparison of controllers on the gauge, with a job per controller and axis.

    Raises:
        UserError: an exported policy is missing, or a controller cannot track the gaits.
    """
    gauge = config.gauge
    check_walkable(config, "gauge.controllers", gauge.controllers)
    protocol = only(to_dict(gauge), *(item.name for item in fields(GaugeProtocol)))
    turn = 2 * math.pi / gauge.directions
    pushed = [turn * index for index in range(gauge.directions)]
    axes = {
        f", {axis.replace('_', ' ')}": {
            "axis": axis,
            "values": gauge.values(axis),
            "directions": pushed if axis == "push" else [None],
            "protocol": protocol,
        }
        for axis in gauge.axes
    }
    cells = lay_out(config, "gauge_axis", "gauge", gauge.controllers, axes, jobs, tracked=False)
    section = {
        **titles(config, gauge.controllers),
        "cells": [(cell.section["controller"], cell.section["axis"]) for cell in cells],
        "protocol": protocol,
        "survival": gauge.survival,
    }
    return job("gauge", "gauge", section, {"cells": cells})


def _import(folder: str, name: str) -> JobSpec:
    """Import of an exported policy; later jobs depend on the content of its files, not the path."""
    place, files = Path(folder).absolute(), {}
    for file in _EXPORTED:
        there, expected = (place / file).is_file(), f"a folder with {', '.join(_EXPORTED)}"
        require(there, f"gauge.policies.{name}", expected, f"no {Path(folder) / file}")
        files[file] = digest_file(place / file)
    section = {"folder": str(place), "files": files}
    return job("policy_import", f"import of {name}", section, tracked=False)
