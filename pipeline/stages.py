"""The stages: gait → library → standing → walking → evaluation → table1 → report.

The stage ``baseline`` is the evaluation of the model-predictive controllers; it needs no other.

Each function says which entry point a stage runs, which part of the configuration is its own and
what its inputs are. A section holds nothing that its stage does not use: it is in the recipe.
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from slider.core.config.convert import to_dict
from slider.core.config.gait import Axis, FormulationConfig, GridConfig, SolveConfig
from slider.core.config.report import SECTION_INPUTS
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
VERIFICATION_GAITS = "slider.verification.stage:run_gaits"
VERIFICATION = "slider.verification.stage:run"
FIGURES = "slider.reports.figures.stage:run"
VERIFICATION_MAPS = "slider.reports.figures.verification_maps:run"
VIDEO = "slider.reports.video:run"
REPORT = "slider.reports.report:run"

POLICY = "policy"
BASELINE_PREFIX = "mpc_wbc_"
Velocity = tuple[float, float]


def all_jobs(config: Config) -> dict[str, JobSpec]:
    """Jobs of everything that can be asked for, by the name of their target."""
    targets = table1_jobs(config)
    library = targets["library"]
    beside = verification_jobs(config, library) | figure_jobs(library)
    return targets | beside | {"report": report(config, targets)}


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


def verification_jobs(config: Config, library: JobSpec) -> dict[str, JobSpec]:
    """The independent checks of the library's gaits; nothing on the way to Table 1 needs them."""
    commands = library.section["velocities"]
    size = config.verification.chunk
    chunks = [commands[start : start + size] for start in range(0, len(commands), size)]
    gaits = [verification_of_gaits(config, chunk, library) for chunk in chunks]
    settings = _only(to_dict(config.verification), "on_failure", "reach", "bounds")
    inputs = {"library": [library], "gaits": gaits}
    section = {"verification": settings}
    job = JobSpec("verification", "verification", code_of(VERIFICATION), section, inputs)
    inputs = {"library": [library], "verification": [job]}
    maps = JobSpec(
        "verification_maps", "maps of the verification", code_of(VERIFICATION_MAPS), {}, inputs
    )
    return {"verification": job, "verification_maps": maps}


def verification_of_gaits(config: Config, commands: list[list[float]], library: JobSpec) -> JobSpec:
    """The checks of some gaits."""
    settings = to_dict(config.verification)
    section = {
        "robot": _without(to_dict(config.robot), "provenance"),
        "posture": to_dict(config.gait.posture),
        "kinematic_map": config.gait.kinematic_map,
        "verification": _without(settings, "chunk", "on_failure", "reach", "bounds"),
        "velocities": commands,
    }
    label = f"verification of {len(commands)} gaits from {commands[0][0]:.2f} m/s"
    code = code_of(VERIFICATION_GAITS)
    inputs = {"library": [library]}
    return JobSpec("verification_gaits", label, code, section, inputs, tracked=False)


def figure_jobs(library: JobSpec) -> dict[str, JobSpec]:
    """Pictures of the gait library; nothing on the way to Table 1 needs them."""
    inputs = {"library": [library]}
    return {"figures": JobSpec("figures", "figures", code_of(FIGURES), {}, inputs)}


def velocities(grid: GridConfig) -> list[Velocity]:
    """Commanded velocities (vx, vy) [m/s] of a grid, each once, sorted."""
    blocks = [(grid.vx, grid.vy), *((block.vx, block.vy) for block in grid.extra)]
    return sorted({(vx, vy) for x, y in blocks for vx in _values(x) for vy in _values(y)})


def _values(axis: Axis | list[float]) -> list[float]:
    """Values rounded to 1e-10, so that grids of other steps share their gaits; no −0."""
    if isinstance(axis, Axis):
        axis = [axis.start + index * axis.step for index in range(axis_size(axis))]
    return [round(value, 10) + 0.0 for value in axis]


def gait_section(config: Config) -> dict[str, Any]:
    """What all gaits share: neither the gains of the simulated drives nor the grid."""
    robot = ("geometry", "links", "virtual_knee", "limits", "capstan")
    settings = to_dict(config.gait)
    return {
        "robot": _only(to_dict(config.robot), *robot),
        "formulation": _only(settings, *(f.name for f in fields(FormulationConfig))),
        "solve": _only(settings, *(f.name for f in fields(SolveConfig))),
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
        # Written into the library, so that its gaits can be compared with the robot's limits.
        "robot": _only(to_dict(config.robot), "geometry", "virtual_knee", "limits"),
        "kinematic_map": config.gait.kinematic_map,
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
    section = {"evaluation": protocol} | _controlled(config, controller, command)
    label = f"evaluation of {controller} at {command:.1f} m/s"
    if controller == POLICY:
        inputs = {"walking": [walking]}
        return JobSpec("evaluation", label, code_of(EVALUATION), section, inputs)
    return JobSpec("baseline", label, code_of(BASELINE), section)


def _controlled(config: Config, controller: str, command: float) -> dict[str, Any]:
    """Robot, plant and controller; the policy comes as an input."""
    section = {"controller": controller, "command": command}
    if controller == POLICY:
        return section | _simulation(config)
    return section | {
        "robot": _without(to_dict(config.robot), "provenance"),
        "plant": _only(to_dict(config.env), "control_period", "physics", "termination"),
        "control": to_dict(getattr(config.control, controller.removeprefix(BASELINE_PREFIX))),
    }


def table1(config: Config, evaluations: list[JobSpec]) -> JobSpec:
    """Table 1 from the records of all evaluations."""
    section = {"evaluation": to_dict(config.evaluation)}
    return JobSpec("table1", "table 1", code_of(TABLE1), section, {"evaluations": evaluations})


def video(config: Config, controller: str, command: float, walking: JobSpec) -> JobSpec:
    """A short film of one controller at one command."""
    section = _controlled(config, controller, command) | {
        "start": to_dict(config.evaluation.start),
        "disturbance": to_dict(config.evaluation.disturbance),
        "video": _without(to_dict(config.report.video), "commands"),
    }
    inputs = {"walking": [walking]} if controller == POLICY else {}
    label = f"video of {controller} at {command:.1f} m/s"
    return JobSpec("video", label, code_of(VIDEO), section, inputs, tracked=False)


def report(config: Config, targets: Mapping[str, JobSpec]) -> JobSpec:
    """The page about everything; its sections say what it needs."""
    available = {name: [job] for name, job in targets.items()} | {
        "gaits": targets["library"].inputs["gaits"],
        "evaluations": targets["table1"].inputs["evaluations"],
        "videos": _videos(config, targets["walking"]),
    }
    names = {name for section in config.report.sections for name in SECTION_INPUTS[section]}
    inputs = {name: jobs for name, jobs in available.items() if name in names}
    section = {
        "report": to_dict(config.report),
        "configuration": _without(to_dict(config), "resources", "tracking"),
        "origins": {name: [_origin(job) for job in jobs] for name, jobs in inputs.items()},
    }
    return JobSpec("report", "report", code_of(REPORT), section, inputs)


def _videos(config: Config, walking: JobSpec) -> list[JobSpec]:
    if config.report.video.renderer == "none":
        return []
    return [
        video(config, controller, command, walking)
        for controller in config.evaluation.controllers
        for command in config.report.video.commands
    ]


def _origin(job: JobSpec) -> dict[str, Any]:
    """Where a result comes from, for the section about it."""
    return {
        "label": job.label,
        "recipe": job.recipe,
        "source": job.code.source,
        "versions": job.code.versions,
    }


def _simulation(config: Config) -> dict[str, Any]:
    robot = _without(to_dict(config.robot), "provenance")
    return {"robot": robot, "env": to_dict(config.env)}


def _only(values: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: values[name] for name in names}


def _without(values: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: value for name, value in values.items() if name not in names}
