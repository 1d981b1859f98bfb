"""The stage ``gauge_axis``: one controller along one axis of the gauge, level by level.

A level is one roll-out of all robots per direction. Levels above one that no robot passes are not
simulated.
"""

from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from slider.config.convert import from_dict
from slider.config.env import DisturbanceConfig, EnvConfig, SensingConfig, TerrainConfig
from slider.config.evaluation import TERRAINS, GaugeProtocol, at_speed
from slider.config.robot import RobotConfig
from slider.config.types import Interval
from slider.control.exported import load_exported
from slider.core import tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.disturbance import Disturbance
from slider.env.physics import BatchedPhysics
from slider.env.rollout import Controller, Recording
from slider.env.terrain import magnitude
from slider.evaluation.stage import Setup, record, seeds_of, set_up

CSV = "cells.csv"
_NO_DEVIATIONS = ("scan_drop_out", "scan_delay")
COUNTS = ("survived", "passed", "mean_velocity")  # empty where a level was not run
COLUMNS = ("level", "value", "direction", "seed", "speed", "robots", *COUNTS)
_WORDS = {  # of a value: format, and factor to the displayed unit
    "friction": ("{:.3g}", 1.0),
    "payload": ("{:.3g} kg", 1.0),
    "delay": ("{:.3g} ms", 1e3),
    "motor_strength": ("{:.3g} %", 1e2),
    "sensor_noise": ("× {:.3g}", 1.0),
    "push": ("{:.3g} N s", 1.0),
}


def words(axis: str, value: float) -> str:
    """A value of an axis as text, such as ``6.25°`` or ``40 ms``."""
    if axis in TERRAINS:
        return magnitude(axis, value)
    text, factor = _WORDS[axis]
    return text.format(factor * value)


def disturbed(
    protocol: GaugeProtocol, axis: str, value: float, direction: float | None = None
) -> DisturbanceConfig:
    """The protocol's disturbance with one axis set to a value, in SI units.

    ``sensor_noise`` multiplies the protocol's white noise. The direction of pushes is measured from
    forward towards left [rad].
    """
    base, exactly = protocol.disturbance, Interval(value, value)
    if axis in TERRAINS:
        return replace(base, terrain=TerrainConfig([axis], exactly, False))  # pyright: ignore[reportArgumentType]
    if axis == "push":
        return replace(base, push=replace(base.push, impulse=exactly, direction=direction))
    if axis == "sensor_noise":
        noise = {name: value * deviation for name, deviation in vars(protocol.sensing).items()}
        return replace(base, sensing=SensingConfig(**noise))
    name = "motor_gain" if axis == "motor_strength" else axis
    return replace(base, **{name: exactly})


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write a row per level, direction [rad], speed [m/s] and seed: robots, survivors, passes."""
    protocol = from_dict(GaugeProtocol, section["protocol"])
    values, directions = section["values"], section["directions"]
    rows, failed, tested = [], False, 0
    for level, value in enumerate(values, 1):
        passed = 0
        for direction in directions:
            job.progress(f"level {level} of at most {len(values)}")
            counts: Mapping[str, Any] = {}
            if not failed:
                counts = _measure(section, inputs, protocol, value, direction, job.threads)
                passed += counts["passed"].sum()
            for block, place in enumerate(product(seeds_of(protocol), protocol.speeds)):
                found = [column[block] for column in counts.values()]
                rows.append([level, value, direction, *place, protocol.robots, *found])
        tested += not failed
        failed = failed or passed == 0
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    tables.write(table, out / CSV)
    return {"levels": tested}


def _measure(
    section: Section,
    inputs: Inputs,
    protocol: GaugeProtocol,
    value: float,
    direction: float | None,
    threads: int,
) -> dict[str, np.ndarray]:
    """Columns ``COUNTS`` of all seeds and speeds at a level."""
    config = disturbed(protocol, section["axis"], value, direction)
    if section["axis"] == "sensor_noise":
        section = with_noisier_sensors(section, value)
    cases = [at_speed(speed) for speed in protocol.speeds]
    recording = record(section, inputs, protocol, cases, threads, config, _simulate)
    return count_passes(recording, protocol)


def count_passes(recording: Recording, protocol: GaugeProtocol) -> dict[str, np.ndarray]:
    """Survivors, robots that pass, mean velocity [m/s] of survivors, of each block of robots.

    A robot passes if it survives and its base has come forward, along the world's x axis, at least
    the share ``distance`` of commanded speed × duration. Robots start at x = 0.
    """
    blocks = (-1, protocol.robots)
    survived = recording.survived.reshape(blocks)
    covered = recording.position[-1, :, 0].reshape(blocks)
    commanded = protocol.duration * recording.command[0, :, 0].reshape(blocks)
    passed = survived & (covered >= protocol.distance * commanded)
    with np.errstate(invalid="ignore"):  # NaN where nobody survived
        mean = np.where(survived, covered, 0.0).sum(axis=1) / survived.sum(axis=1)
    counts = (survived.sum(axis=1), passed.sum(axis=1), mean / protocol.duration)
    return dict(zip(COUNTS, counts, strict=True))


def with_noisier_sensors(section: Section, factor: float) -> Section:
    """A section whose onboard sensors, if it has any, have ``factor`` times the errors."""
    key = "plant" if "plant" in section else "env"
    onboard = section[key]["onboard"]
    if onboard is None:
        return section
    sensors = {
        name: value if name in _NO_DEVIATIONS else factor * value
        for name, value in onboard["sensors"].items()
    }
    return section | {key: section[key] | {"onboard": onboard | {"sensors": sensors}}}


def _simulate(
    section: Section, inputs: Inputs, count: int, disturbance: Disturbance, threads: int
) -> Setup:
    """Set up a controller whose fallen robots can be deactivated."""
    build = _set_up_exported if "policy" in inputs else set_up
    setup = build(section, inputs, count, disturbance, threads)
    if "control" in section:
        return setup
    return setup._replace(controller=_Deactivatable(setup.controller))


def _set_up_exported(
    section: Section, inputs: Inputs, count: int, disturbance: Disturbance, threads: int
) -> Setup:
    robot, env = from_dict(RobotConfig, section["robot"]), from_dict(EnvConfig, section["env"])
    physics = BatchedPhysics(
        robot, env.physics, count, threads, disturbance=disturbance, onboard=env.estimation
    )
    return Setup(load_exported(inputs["policy"][0], robot, env), physics, env)


class _Deactivatable:
    """A policy whose fallen robots need no simulation; its network costs the same with them."""

    def __init__(self, controller: Controller) -> None:
        self.reset, self.set_velocity = controller.reset, controller.set_velocity
        self.control = controller.control

    def deactivate(self, robots: np.ndarray) -> None:
        """Do nothing: the roll-out deactivates them."""
