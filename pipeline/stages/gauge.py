"""The gauge: each controller along each axis, and their comparison."""

import math
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from pipeline.stages.entries import job, only
from pipeline.stages.evaluation import (
    base_of,
    check_walkable,
    control_inputs,
    control_section,
    labels,
)
from slider.artefacts.plan import JobSpec
from slider.config.control import POLICY
from slider.config.convert import to_dict
from slider.config.evaluation import GaugeProtocol
from slider.config.schema import Config
from slider.control import LAYOUT, ONNX, REFERENCE
from slider.core.errors import require
from slider.core.files import digest_file

_FILES = (ONNX, LAYOUT, REFERENCE)  # of an exported policy


def gauge_job(config: Config, jobs: Mapping[str, JobSpec]) -> JobSpec:
    """The comparison, and with it a job per controller and axis.

    Raises:
        UserError: an exported policy is not there, or a controller cannot walk the gaits.
    """
    gauge = config.gauge
    check_walkable(config, "gauge.controllers", gauge.controllers)
    cells = [
        _axis(config, controller, axis, jobs)
        for controller in gauge.controllers
        for axis in gauge.axes
    ]
    section = {
        "labels": labels(config, gauge.controllers),
        "robot": config.robot.name,
        "cells": [(cell.section["controller"], cell.section["axis"]) for cell in cells],
        "protocol": _protocol(config),
        "survival": gauge.survival,
    }
    return job("gauge", "gauge", section, {"cells": cells})


def _axis(config: Config, controller: str, axis: str, jobs: Mapping[str, JobSpec]) -> JobSpec:
    """One controller along one axis."""
    gauge, base = config.gauge, base_of(controller)
    if base in gauge.policies:
        like = f"{POLICY}{controller.removeprefix(base)}"
        section = control_section(config, like) | {"controller": controller}
        inputs = {"policy": [_import(gauge.policies[base], base)]}
    else:
        section = control_section(config, controller)
        inputs = control_inputs(config, controller, jobs)
    turn = 2 * math.pi / gauge.directions
    pushed = [turn * index for index in range(gauge.directions)]
    section |= {
        "axis": axis,
        "values": gauge.values(axis),
        "directions": pushed if axis == "push" else [None],
        "protocol": _protocol(config),
    }
    label = f"gauge of {controller}, {axis.replace('_', ' ')}"
    return job("gauge_axis", label, section, inputs, tracked=False)


def _protocol(config: Config) -> dict[str, Any]:
    return only(to_dict(config.gauge), *(item.name for item in fields(GaugeProtocol)))


def _import(folder: str, name: str) -> JobSpec:
    """The files of an exported policy; what follows depends on their content, not on the place."""
    place, files = Path(folder).absolute(), {}
    for file in _FILES:
        there, expected = (place / file).is_file(), f"a folder with {', '.join(_FILES)}"
        require(there, f"gauge.policies.{name}", expected, f"no {Path(folder) / file}")
        files[file] = digest_file(place / file)
    section = {"folder": str(place), "files": files}
    return job("policy_import", f"import of {name}", section, tracked=False)
