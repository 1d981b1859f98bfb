"""The stages: gait → library → standing → walking → evaluation → table1 → report.

The stage ``baseline`` is the evaluation of the model-predictive controllers; it needs no other.
The ablation compares several configurations and has a module of its own.
The stage ``policy_export`` hangs off ``walking``: another exporter must not retrain the policy.
Protocols beside that of Table 1 (``config.protocols``) have the same evaluations and a report each.

Each function says which entry point a stage runs, which part of the configuration is its own and
what its inputs are. A section holds nothing that its stage does not use: it is in the recipe.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from slider.core.config.convert import to_dict
from slider.core.config.evaluation import EvaluationConfig
from slider.core.config.gait import Axis, FormulationConfig, GridConfig, SolveConfig, axis_size
from slider.core.config.library_use import uses_library
from slider.core.config.report import SECTION_INPUTS
from slider.core.config.schema import Config
from slider.core.plan import JobSpec
from slider.core.recipe import code_of

GAIT = "slider.gait.stage:run"
LIBRARY = "slider.library.stage:run"
STANDING = "slider.training.stage:run_standing"
WALKING = "slider.training.stage:run_walking"
POLICY_EXPORT = "slider.control.export.stage:run"
EVALUATION = "slider.evaluation.stage:run"
BASELINE = "slider.evaluation.baseline:run"
TABLE1 = "slider.reports.table1:run"
SPEEDS = "slider.reports.protocols.speeds:run"
PROFILE = "slider.reports.protocols.profile:run"
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
    """Jobs of everything but the page and the ablation, by the name of their target."""
    targets = table1_jobs(config)
    library = targets["library"]
    targets |= verification_jobs(config, library) | figure_jobs(library)
    targets |= {"policy_export": policy_export(targets["walking"])}
    return targets | protocol_jobs(config, targets["walking"])


def table1_jobs(config: Config) -> dict[str, JobSpec]:
    """Jobs up to Table 1 by the name of their target."""
    library = library_job(config)
    trainings = training_jobs(config, library)
    evaluations = evaluations_of(config, config.evaluation, trainings["walking"])
    return {"library": library, **trainings, "table1": table1(config, evaluations)}


def library_job(config: Config) -> JobSpec:
    """The gait library, and with it all gaits."""
    shared = gait_section(config)
    gaits = [gait(shared, velocity) for velocity in velocities(config.gait.grid)]
    return gait_library(config, gaits)


def training_jobs(config: Config, library: JobSpec, note: str = "") -> dict[str, JobSpec]:
    """``standing``, where the configuration wants it, and ``walking``.

    Args:
        config: of the trainings.
        library: for those that need it.
        note: added to the labels.
    """
    if not config.train.pretraining:
        return {"walking": walking_training(config, library, None, note)}
    standing = standing_training(config, library, note)
    return {"standing": standing, "walking": walking_training(config, library, standing, note)}


def protocol_jobs(config: Config, walking: JobSpec) -> dict[str, JobSpec]:
    """The report of each further protocol; nothing on the way to Table 1 needs them."""
    return {name: protocol_report(config, name, walking) for name in config.protocols}


def protocol_report(config: Config, name: str, walking: JobSpec) -> JobSpec:
    """Table and figure of a protocol of constant speeds, or of one with a changing command."""
    protocol = config.protocols[name]
    inputs = {"evaluations": evaluations_of(config, protocol, walking)}
    section = {"name": name, "evaluation": protocol_section(protocol)}
    if protocol.profile is None:
        return JobSpec("speeds", name, code_of(SPEEDS), section, inputs)
    return JobSpec("profile", name, code_of(PROFILE), section, inputs)


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


def standing_training(config: Config, library: JobSpec, note: str = "") -> JobSpec:
    """Pre-training; of the library it needs the step times of the clock at most."""
    train = config.train.standing
    section = _simulation(config) | {"train": to_dict(train)}
    inputs = {"library": [library]} if uses_library(config.env, train) else {}
    return JobSpec("standing", f"standing{note}", code_of(STANDING), section, inputs)


def walking_training(
    config: Config, library: JobSpec, standing: JobSpec | None, note: str = ""
) -> JobSpec:
    """Training from the standing policy and guided by the library, where there are these."""
    train = config.train.walking
    section = _simulation(config) | {"train": to_dict(train)}
    inputs = {"library": [library]} if uses_library(config.env, train) else {}
    if standing is not None:
        inputs["standing"] = [standing]
    return JobSpec("walking", f"walking{note}", code_of(WALKING), section, inputs)


def policy_export(walking: JobSpec) -> JobSpec:
    """The policy for use without this package; the policy file brings its configuration along."""
    section = {"origin": _origin(walking)}
    code = code_of(POLICY_EXPORT)
    return JobSpec("policy_export", "policy export", code, section, {"walking": [walking]})


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
    settings = _without(protocol_section(protocol), "controllers", "commands")
    section = {"evaluation": settings} | _controlled(config, controller, command)
    what = "changing commands" if command is None else f"{command:.1f} m/s"
    label = f"evaluation of {controller} at {what}{note}"
    if controller == POLICY:
        inputs = {"walking": [walking]}
        return JobSpec("evaluation", label, code_of(EVALUATION), section, inputs)
    return JobSpec("baseline", label, code_of(BASELINE), section)


def protocol_section(protocol: EvaluationConfig) -> dict[str, Any]:
    """A protocol without the options that it does not use: new ones leave old recipes alone."""
    return {name: value for name, value in to_dict(protocol).items() if value is not None}


def _controlled(config: Config, controller: str, command: float | None) -> dict[str, Any]:
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
    """Table 1 from the records of all evaluations.

    A library that the policy was trained with also gives the gaits' own sway. A table without one
    (of baselines alone, of a training without library) does not wait for it.
    """
    section = {"evaluation": protocol_section(config.evaluation)}
    trainings = [job for item in evaluations for job in item.inputs.get("walking", ())]
    inputs = {"evaluations": evaluations}
    if trainings and "library" in trainings[0].inputs:
        inputs["library"] = list(trainings[0].inputs["library"])
    return JobSpec("table1", "table 1", code_of(TABLE1), section, inputs)


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
    available = _available(targets) | {"videos": _videos(config, targets["walking"])}
    names = [name for section in config.report.sections for name in SECTION_INPUTS[section]]
    inputs = {name: available[name] for name in dict.fromkeys(names)}
    section = {
        "report": to_dict(config.report),
        "configuration": _shown(config, inputs),
        "origins": {name: [_origin(job) for job in jobs] for name, jobs in inputs.items()},
    }
    return JobSpec("report", "report", code_of(REPORT), section, inputs)


def _shown(config: Config, inputs: Mapping[str, Sequence[JobSpec]]) -> dict[str, Any]:
    """The configuration without what has no part in the page."""
    shown = _without(to_dict(config), "resources", "tracking", "ablation", "protocols")
    shown["evaluation"] = protocol_section(config.evaluation)
    protocols = {
        name: protocol_section(p) for name, p in config.protocols.items() if name in inputs
    }
    if protocols:
        shown["protocols"] = protocols
    if "ablation" in inputs:
        shown["ablation"] = to_dict(config.ablation)
    return shown


def _available(targets: Mapping[str, JobSpec]) -> dict[str, Sequence[JobSpec]]:
    """What a section can ask for: a target, or as ``target.group`` a group of its inputs."""
    groups = {
        f"{name}.{group}": jobs
        for name, job in targets.items()
        for group, jobs in job.inputs.items()
    }
    return {name: [job] for name, job in targets.items()} | groups


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
        "stage": job.stage,
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
