"""The stages: gait → library → standing → walking → evaluation → table1.

The stage ``baseline`` is the evaluation of the model-predictive controllers; it needs no other.

Each function says which entry point a stage runs, which part of the configuration is its own and
what its inputs are. A section holds nothing that its stage does not use: it is in the recipe.
"""

from typing import Any

from slider.core.config.convert import to_dict
from slider.core.config.gait import Axis, GridConfig
from slider.core.config.schema import Config
from slider.core.config.validate import axis_size
from slider.core.plan import JobSpec
from slider.core.recipe import code_of

GAIT = "slider.gait.stage:run"
LIBRARY = "slider.library.stage:run"
STANDING = "slider.training.stage:run_standing"
WALKING = "slider.training.stage:run_walking"
EVALUATION = "slider.evaluation.stage:run"
BASELINE = "slider.evaluation.baseline:run"
TABLE1 = "slider.reports.table1:run"

POLICY = "policy"
BASELINE_PREFIX = "mpc_wbc_"
Velocity = tuple[float, float]


def table1_jobs(config: Config) -> dict[str, JobSpec]:
    """Jobs up to Table 1 by the name of their target."""
    shared = gait_section(config)
    gaits = [gait(shared, velocity) for velocity in velocities(config.gait.grid)]
    library = gait_library(config, gaits)
    standing = standing_training(config, library)
    walking = walking_training(config, library, standing)
    evaluations = [
        evaluation(config, controller, command, walking)
        for controller in config.evaluation.controllers
        for command in config.evaluation.commands
    ]
    return {
        "library": library,
        "standing": standing,
        "walking": walking,
        "table1": table1(config, evaluations),
    }


def velocities(grid: GridConfig) -> list[Velocity]:
    """Commanded velocities (vx, vy) [m/s] of a grid, each once, sorted."""
    blocks = [(grid.vx, grid.vy), *((block.vx, block.vy) for block in grid.extra)]
    return sorted({(vx, vy) for x, y in blocks for vx in _values(x) for vy in _values(y)})


def _values(axis: Axis) -> list[float]:
    """Values rounded to 1e-10, so that grids of other steps share their gaits; no −0."""
    steps = range(axis_size(axis))
    return [round(axis.start + index * axis.step, 10) + 0.0 for index in steps]


def gait_section(config: Config) -> dict[str, Any]:
    """What all gaits share: neither the gains of the simulated drives nor the grid."""
    return {
        "robot": _only(to_dict(config.robot), "geometry", "links", "virtual_knee", "limits"),
        "gait": _without(to_dict(config.gait), "grid"),
    }


def gait(shared: dict[str, Any], velocity: Velocity) -> JobSpec:
    """One gait; it does not know of the other velocities."""
    label = f"gait {velocity[0]:.2f} {velocity[1]:+.2f} m/s"
    section = shared | {"velocity": list(velocity)}
    # 125 runs would bury the others: the library stage records the gaits as a table.
    return JobSpec("gait", label, code_of(GAIT), section, tracked=False)


def gait_library(config: Config, gaits: list[JobSpec]) -> JobSpec:
    """All gaits in one store."""
    section = {
        "library": to_dict(config.library),
        "velocities": [job.section["velocity"] for job in gaits],
    }
    return JobSpec("library", "gait library", code_of(LIBRARY), section, {"gaits": gaits})


def standing_training(config: Config, library: JobSpec) -> JobSpec:
    """Pre-training; the library is there for the step times of the clock."""
    section = _simulation(config) | {"train": to_dict(config.train.standing)}
    return JobSpec("standing", "standing", code_of(STANDING), section, {"library": [library]})


def walking_training(config: Config, library: JobSpec, standing: JobSpec) -> JobSpec:
    """Guided training from the standing policy."""
    section = _simulation(config) | {"train": to_dict(config.train.walking)}
    inputs = {"library": [library], "standing": [standing]}
    return JobSpec("walking", "walking", code_of(WALKING), section, inputs)


def evaluation(config: Config, controller: str, command: float, walking: JobSpec) -> JobSpec:
    """The protocol of one controller at one command."""
    protocol = _without(to_dict(config.evaluation), "controllers", "commands")
    section = {"evaluation": protocol, "controller": controller, "command": command}
    label = f"evaluation of {controller} at {command:.1f} m/s"
    if controller == POLICY:
        section |= _simulation(config)
        inputs = {"walking": [walking]}
        return JobSpec("evaluation", label, code_of(EVALUATION), section, inputs)
    section |= {
        "robot": _without(to_dict(config.robot), "provenance"),
        "plant": _only(to_dict(config.env), "control_period", "physics", "termination"),
        "control": to_dict(getattr(config.control, controller.removeprefix(BASELINE_PREFIX))),
    }
    return JobSpec("baseline", label, code_of(BASELINE), section)


def table1(config: Config, evaluations: list[JobSpec]) -> JobSpec:
    """Table 1 from the records of all evaluations."""
    section = {"evaluation": to_dict(config.evaluation)}
    return JobSpec("table1", "table 1", code_of(TABLE1), section, {"evaluations": evaluations})


def _simulation(config: Config) -> dict[str, Any]:
    robot = _without(to_dict(config.robot), "provenance")
    return {"robot": robot, "env": to_dict(config.env)}


def _only(values: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: values[name] for name in names}


def _without(values: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: value for name, value in values.items() if name not in names}
