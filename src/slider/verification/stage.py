"""The stages ``verification_gaits``, some gaits per job, and ``verification``, which collects."""

import importlib.util
import json
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import pandas as pd

from slider.config.convert import from_dict
from slider.config.gait import CheckConfig, Posture
from slider.config.robot import RobotConfig
from slider.core import tables
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.library.reader import STORE, GaitLibrary
from slider.robot.names import VELOCITY
from slider.verification import summary
from slider.verification.quantities import QUANTITIES
from slider.verification.stored import StoredGait, gaits_of

RECORDS = "gaits.json"
CSV, MARKDOWN = "verification.csv", "verification.md"
Check = Callable[[StoredGait], dict[str, float]]


def checks(
    robot: RobotConfig, posture: Posture, dynamics: str, config: CheckConfig
) -> dict[str, Check]:
    """Checks by name; each returns some of ``QUANTITIES``.

    The ``robot`` is the plant, and the source of pinocchio's model; ``dynamics`` are those of the
    gaits, ``prismatic`` or ``knee``.

    Raises:
        UserError: pinocchio is not installed.
    """
    if importlib.util.find_spec("pinocchio") is None:
        raise UserError("expected pinocchio, found none: pip install 'slider-ehzd[verify]'")
    from slider.verification import dense, plant
    from slider.verification import dynamics as residuals
    from slider.verification.pin_robot import PinRobot

    floating, simulated = PinRobot(robot, dynamics), plant.Plant(robot)
    between = {"pinocchio": floating, "robot": robot, "posture": posture, "points": config.points}
    return {
        "dynamics": partial(residuals.inverse_dynamics, robot=floating),
        "impact": partial(residuals.impact, robot=floating),
        "mean_velocity": residuals.mean_velocity,
        "periodicity": residuals.periodicity,
        "roll": partial(residuals.roll, robot=floating, integrator=config.integrator),
        "plant": partial(plant.inverse_dynamics, plant=simulated),
        "plant_impact": partial(plant.impact, plant=simulated),
        "dense": partial(dense.between_nodes, **between),
        "legs": partial(dense.legs_apart, plant=simulated, points=config.points),
    }


def check_gait(gait: StoredGait, table: Mapping[str, Check]) -> dict[str, float]:
    """All quantities of a gait; NaN counts as the worst value."""
    values = {name: value for check in table.values() for name, value in check(gait).items()}
    worst = {name: -math.inf if QUANTITIES[name].at_least else math.inf for name in values}
    return {n: worst[n] if math.isnan(v) else v for n, v in values.items()}


def run_gaits(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Check the gaits of some commanded velocities; a hole of the library is left out."""
    library = GaitLibrary.load(inputs["library"][0] / STORE)
    table = checks(
        from_dict(RobotConfig, section["robot"]),
        from_dict(Posture, section["posture"]),
        library.dynamics,
        from_dict(CheckConfig, section["verification"]),
    )
    wanted, records = set(map(tuple, section["velocities"])), []
    gaits = [gait for gait in gaits_of(library) if tuple(gait.velocities) in wanted]
    for gait in gaits:
        velocity = dict(zip(VELOCITY, gait.velocities.tolist(), strict=True))
        records.append(velocity | check_gait(gait, table))
        job.progress(f"{len(records)} of {len(gaits)} gaits")
    (out / RECORDS).write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")
    return {"gaits": len(records)}


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Compare all values with their bounds and write both tables.

    Raises:
        UserError: a bound does not hold, and ``verification.on_failure`` is ``error``.
    """
    settings = section["verification"]
    bounds: summary.Bounds = settings["bounds"]
    table = _table(inputs["gaits"], GaitLibrary.load(inputs["library"][0] / STORE))
    table, failures = summary.judge(table, bounds)
    if failures and settings["on_failure"] == "error":
        raise UserError(
            f"{len(failures)} bounds do not hold, such as {failures[0]} "
            "(verification.on_failure=report writes the table all the same)"
        )
    tables.write(table, out / CSV)
    summary.write_markdown(out / MARKDOWN, table, bounds, failures)
    return {"gaits": len(table), "passed": not failures, "failures": len(failures)}


def _table(folders: Sequence[Path], library: GaitLibrary) -> pd.DataFrame:
    """One row per gait in the library's order; NaN where a quantity does not apply."""
    texts = [(folder / RECORDS).read_text(encoding="utf-8") for folder in folders]
    table = pd.DataFrame([record for text in texts for record in json.loads(text)])
    table = table.reindex(columns=[*VELOCITY, *QUANTITIES]).set_index(list(VELOCITY))
    order = pd.MultiIndex.from_tuples([tuple(v) for v in library.velocities.tolist()])
    return table.loc[order].rename_axis(list(VELOCITY)).reset_index()
