"""Checks of values that types cannot express. Each failure is one line."""

import math
from collections.abc import Iterable
from dataclasses import fields, is_dataclass
from typing import Any

from slider.core.config.ablation import AblationConfig
from slider.core.config.control import MpcConfig, ObserverConfig
from slider.core.config.disturbance import DisturbanceConfig
from slider.core.config.env import EnvConfig
from slider.core.config.evaluation import EvaluationConfig, ProfileConfig
from slider.core.config.gait import Axis, GaitConfig
from slider.core.config.interval import Interval
from slider.core.config.report import PROTOCOL_SECTIONS, SECTION_INPUTS, ReportConfig
from slider.core.config.robot import RobotConfig
from slider.core.config.schema import Config
from slider.core.config.train import CurriculumConfig, TrainConfig
from slider.core.config.verification import VerificationConfig
from slider.core.config.video import RENDERERS
from slider.core.errors import UserError
from slider.robot.names import LEG_JOINTS

MAX_GRID = 5000
MAX_NODES = 201
MAX_CELLS = 400


def protocols(config: Config) -> dict[str, EvaluationConfig]:
    """Table 1's and the others, by their key."""
    others = {f"protocols.{name}": protocol for name, protocol in config.protocols.items()}
    return {"evaluation": config.evaluation, **others}


def validate(config: Config) -> None:
    """Refuse impossible values.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    _finite(config, "")
    _robot(config.robot)
    _gait(config.gait)
    _env(config.env)
    for name in ("standing", "walking"):
        _train(getattr(config.train, name), config.env, f"train.{name}")
        disturbance = getattr(config.train, name).disturbance
        _disturbance(disturbance, config.env, f"train.{name}.disturbance")
    settings = [item.name for item in fields(config.control)]
    for name in settings:
        _control(getattr(config.control, name), config.env, f"control.{name}")
    controllers = ["policy", *(f"mpc_wbc_{name}" for name in settings)]
    _require(
        config.evaluation.profile is None,
        "evaluation.profile",
        "none (the commands of Table 1 are constant; see protocols)",
        "one",
    )
    for key, protocol in protocols(config).items():
        _evaluation(protocol, controllers, key)
        _disturbance(protocol.disturbance, config.env, f"{key}.disturbance")
    _verification(config.verification)
    _report(config.report, config.protocols, config.env.control_period)
    _ablation(config.ablation)
    _at_least("resources.threads", config.resources.threads, 1)


def _fail(key: str, expected: str, found: Any) -> None:
    raise UserError(f"{key}: expected {expected}, found {found}")


def _require(condition: bool, key: str, expected: str, found: Any) -> None:
    if not condition:
        _fail(key, expected, found)


def _at_least(key: str, value: float, least: float) -> None:
    _require(value >= least, key, f"a value ≥ {least}", value)


def _positive(key: str, value: float) -> None:
    _require(value > 0, key, "a positive value", value)


def _not_negative(key: str, value: float) -> None:
    _at_least(key, value, 0)


def _in(key: str, value: Any, allowed: Iterable[Any]) -> None:
    options = tuple(allowed)
    _require(value in options, key, f"one of {', '.join(map(str, options))}", value)


def _finite(node: Any, key: str) -> None:
    if isinstance(node, float):
        _require(math.isfinite(node), key, "a finite number", node)
    elif is_dataclass(node):
        for item in fields(node):
            _finite(getattr(node, item.name), f"{key}.{item.name}".lstrip("."))
    elif isinstance(node, dict):
        for name, value in node.items():
            _finite(value, f"{key}.{name}")
    elif isinstance(node, (list, tuple)):
        for index, value in enumerate(node):
            _finite(value, f"{key}[{index}]")


def _robot(robot: RobotConfig) -> None:
    for table in ("limits", "drives", "gains"):
        found = tuple(getattr(robot, table))
        _require(
            set(found) == set(LEG_JOINTS),
            f"robot.{table}",
            f"the joints {', '.join(LEG_JOINTS)}",
            ", ".join(found),
        )
    for name, limit in robot.limits.items():
        _require(limit.lower < limit.upper, f"robot.limits.{name}", "lower < upper", limit)
    for item in fields(robot.links):
        _positive(f"robot.links.{item.name}.mass", getattr(robot.links, item.name).mass)
    for item in fields(robot.capstan):
        _positive(f"robot.capstan.{item.name}", getattr(robot.capstan, item.name))
    _positive("robot.geometry.leg_length", robot.geometry.leg_length)
    knee = robot.virtual_knee
    reach = knee.thigh_length + knee.shank_length
    _require(
        reach > robot.geometry.leg_length,
        "robot.virtual_knee",
        f"thigh + shank longer than the leg ({robot.geometry.leg_length} m)",
        reach,
    )


def axis_size(axis: Axis | list[float]) -> int:
    """Number of values of an axis; the stop counts when the steps reach it within 1e-6."""
    if isinstance(axis, list):
        return len(axis)
    if axis.step <= 0 or axis.stop < axis.start:
        return 0
    return math.floor((axis.stop - axis.start) / axis.step + 1e-6) + 1


def _axis(key: str, axis: Axis | list[float]) -> int:
    if isinstance(axis, Axis):
        _positive(f"{key}.step", axis.step)
    size = axis_size(axis)
    _require(size > 0, key, "start ≤ stop, or a list (a grid that is not empty)", axis)
    return size


def _gait(gait: GaitConfig) -> None:
    size = _axis("gait.grid.vx", gait.grid.vx) * _axis("gait.grid.vy", gait.grid.vy)
    for index, block in enumerate(gait.grid.extra):
        key = f"gait.grid.extra[{index}]"
        size += _axis(f"{key}.vx", block.vx) * _axis(f"{key}.vy", block.vy)
    _require(size <= MAX_GRID, "gait.grid", f"at most {MAX_GRID} velocities", size)
    nodes = gait.nodes
    _require(
        5 <= nodes <= MAX_NODES and nodes % 2 == 1,
        "gait.nodes",
        f"an odd number from 5 to {MAX_NODES}",
        nodes,
    )
    _require(3 <= gait.degree <= 12, "gait.degree", "a degree from 3 to 12", gait.degree)
    _in("gait.transcription", gait.transcription, ("bezier", "collocation"))
    _in("gait.cost", gait.cost, ("paper", "torque", "transport"))
    _in("gait.kinematic_map", gait.kinematic_map, ("exact", "paper"))
    _interval("gait.step_time", gait.step_time.lower, gait.step_time.upper)
    _positive("gait.step_time.lower", gait.step_time.lower)
    _in("gait.step_time.law", gait.step_time.law, ("free", "fixed", "speed"))
    _require(
        gait.step_time.lower <= gait.step_time.value <= gait.step_time.upper,
        "gait.step_time.value",
        f"from {gait.step_time.lower} to {gait.step_time.upper} s",
        gait.step_time.value,
    )
    _interval("gait.touchdown.down", gait.touchdown.down_min, gait.touchdown.down_max)
    _require(
        gait.posture.clearance + gait.posture.clearance_margin < gait.posture.swing_height,
        "gait.posture.clearance",
        f"with its margin less than swing_height ({gait.posture.swing_height} m)",
        gait.posture.clearance + gait.posture.clearance_margin,
    )
    _interval("gait.posture.knee", gait.posture.knee_min, gait.posture.knee_max)
    _positive("gait.contact.friction", gait.contact.friction)
    _at_least("gait.posture.clearance_margin", gait.posture.clearance_margin, 0)
    _at_least("gait.solver.max_iterations", gait.solver.max_iterations, 1)
    _require(bool(gait.solver.ladder), "gait.solver.ladder", "at least one rung", "none")
    for rung in gait.solver.ladder:
        _in("gait.solver.ladder", rung, ("cold", "brisk", "crouched", "ramp"))
    _in("gait.solver.keep", gait.solver.keep, ("first", "best"))


def _interval(key: str, lower: float, upper: float) -> None:
    _require(lower <= upper, key, "lower ≤ upper", f"{lower} > {upper}")


def _env(env: EnvConfig) -> None:
    _positive("env.control_period", env.control_period)
    _positive("env.physics.timestep", env.physics.timestep)
    _at_least("env.physics.substeps", env.physics.substeps, 1)
    period = env.physics.timestep * env.physics.substeps
    _require(
        abs(period - env.control_period) < 1e-9,
        "env.physics",
        f"timestep × substeps = control_period ({env.control_period} s)",
        period,
    )
    _require(
        set(env.action.scale) == set(LEG_JOINTS),
        "env.action.scale",
        f"the joints {', '.join(LEG_JOINTS)}",
        ", ".join(env.action.scale),
    )
    _positive("env.action.clip", env.action.clip)
    _in("env.action.about", env.action.about, ("nominal", "gait"))
    _require(
        env.phase.enabled or env.action.about == "nominal",
        "env.action.about",
        "nominal where there is no phase",
        env.action.about,
    )
    _at_least("env.phase.step_time", env.phase.step_time, 0.0)
    _positive("env.observation.clip", env.observation.clip)
    _require(bool(env.observation.terms), "env.observation.terms", "at least one term", "none")
    _require(
        env.phase.enabled or not (env.phase.mirror or env.phase.halt),
        "env.phase",
        "mirror and halt only with a phase",
        env.phase,
    )


def _train(train: TrainConfig, env: EnvConfig, key: str) -> None:
    _at_least(f"{key}.iterations", train.iterations, 0)
    _at_least(f"{key}.num_envs", train.num_envs, 1)
    _at_least(f"{key}.steps_per_iteration", train.steps_per_iteration, 1)
    _positive(f"{key}.episode_length", train.episode_length)
    for name in ("vx", "vy", "yaw_rate"):
        interval: Interval = getattr(train.commands, name)
        _interval(f"{key}.commands.{name}", interval.lower, interval.upper)
    _curriculum(train.commands.curriculum, f"{key}.commands.curriculum")
    _in(f"{key}.guide.gait", train.guide.gait, ("interpolated", "nearest"))
    _in(f"{key}.ppo.symmetry", train.ppo.symmetry, ("none", "augmentation", "loss"))
    _at_least(f"{key}.ppo.symmetry_weight", train.ppo.symmetry_weight, 0.0)
    _require(
        train.ppo.symmetry == "none" or not env.phase.mirror,
        f"{key}.ppo.symmetry",
        "none where env.phase.mirror shows the network left stance only",
        train.ppo.symmetry,
    )
    _in(f"{key}.ppo.precision", train.ppo.precision, ("auto", "float32", "bfloat16"))
    _in(f"{key}.ppo.schedule", train.ppo.schedule, ("adaptive", "fixed"))
    anneal = train.ppo.anneal
    _require(0 <= anneal.start <= 1, f"{key}.ppo.anneal.start", "a share in [0, 1]", anneal.start)
    _positive(f"{key}.ppo.anneal.desired_kl", anneal.desired_kl)
    _not_negative(f"{key}.ppo.anneal.entropy_coefficient", anneal.entropy_coefficient)
    batch = train.num_envs * train.steps_per_iteration
    _require(
        1 <= train.ppo.mini_batches <= batch,
        f"{key}.ppo.mini_batches",
        f"1 to {batch} (num_envs × steps_per_iteration)",
        train.ppo.mini_batches,
    )
    _require(bool(train.network.hidden), f"{key}.network.hidden", "at least one layer", "none")
    _require(bool(train.reward.terms), f"{key}.reward.terms", "at least one term", "none")
    _at_least(f"{key}.selection.robots", train.selection.robots, 1)
    _at_least(f"{key}.selection.interval", train.selection.interval, 1)


def _curriculum(curriculum: CurriculumConfig, key: str) -> None:
    for name in ("start", "success"):
        value = getattr(curriculum, name)
        _require(0 < value <= 1, f"{key}.{name}", "a share in (0, 1]", value)
    _positive(f"{key}.growth", curriculum.growth)


def _control(control: MpcConfig, env: EnvConfig, key: str) -> None:
    physics, step, planner = env.physics, control.step, control.planner
    _at_least(f"{key}.substeps", control.substeps, 1)
    _require(
        physics.substeps % control.substeps == 0,
        f"{key}.substeps",
        f"a divisor of env.physics.substeps ({physics.substeps})",
        control.substeps,
    )
    rate = 1 / (physics.timestep * control.substeps)
    _require(rate > 199.9, f"{key}.substeps", "a control rate of at least 200 Hz", f"{rate:.0f} Hz")
    _interval(f"{key}.step", step.time_min, step.time)
    _interval(f"{key}.step", step.time, step.time_max)
    for name, value in (
        ("step.time_min", step.time_min),
        ("step.width", step.width),
        ("step.apex", step.apex),
        ("planner.period", planner.period),
        ("planner.lock", planner.lock),
        ("planner.acceleration", planner.acceleration),
        ("entry.duration", control.entry.duration),
        ("whole_body.friction", control.whole_body.friction),
        ("whole_body.force_max", control.whole_body.force_max),
        *(
            (f"whole_body.regularisation[{i}]", control.whole_body.regularisation[i])
            for i in (0, 1)
        ),
    ):
        _positive(f"{key}.{name}", value)
    _at_least(f"{key}.step.time_change", step.time_change, 0.0)
    _at_least(f"{key}.planner.steps", planner.steps, 1)
    _interval(f"{key}.planner.width_min", planner.width_min, planner.width_max)
    if control.observer is not None:
        _observer(control.observer, physics.timestep * control.substeps, f"{key}.observer")


def _observer(observer: ObserverConfig, period: float, key: str) -> None:
    _not_negative(f"{key}.delay", observer.delay)
    _multiple(f"{key}.delay", observer.delay, period)
    for name in ("position", "velocity"):
        value = getattr(observer, name)
        _require(0 < value <= 1, f"{key}.{name}", "a share in (0, 1]", value)


def _evaluation(evaluation: EvaluationConfig, controllers: Iterable[str], key: str) -> None:
    if evaluation.profile is None:
        _require(bool(evaluation.commands), f"{key}.commands", "at least one command", "none")
    else:
        _require(
            not evaluation.commands, f"{key}.commands", "none with a profile", evaluation.commands
        )
        _profile(evaluation.profile, evaluation.duration, f"{key}.profile")
    _require(bool(evaluation.controllers), f"{key}.controllers", "at least one controller", "none")
    for name in evaluation.controllers:
        _in(f"{key}.controllers", name, controllers)
    _at_least(f"{key}.trials", evaluation.trials, 1)
    _at_least(f"{key}.robots", evaluation.robots, 1)
    _positive(f"{key}.duration", evaluation.duration)
    _require(
        0 <= evaluation.steady_from < evaluation.duration,
        f"{key}.steady_from",
        f"a time in [0, {evaluation.duration}) s",
        evaluation.steady_from,
    )


def _profile(profile: ProfileConfig, duration: float, key: str) -> None:
    for name in ("ramp", "settle"):
        _at_least(f"{key}.{name}", getattr(profile, name), 0.0)
    _positive(f"{key}.window", profile.window)
    _require(bool(profile.segments), f"{key}.segments", "at least one segment", "none")
    names = [segment.name for segment in profile.segments]
    _require(len(set(names)) == len(names), f"{key}.segments", "each name once", names)
    times = [segment.time for segment in profile.segments]
    _require(times[0] == 0.0, f"{key}.segments[0].time", "0 s", times[0])
    shortest = max(profile.ramp, profile.settle)
    for index, (start, end) in enumerate(zip(times, [*times[1:], duration], strict=True)):
        _require(
            end - start > shortest,
            f"{key}.segments[{index}]",
            f"longer than ramp and settle ({shortest} s)",
            f"{end - start:g} s",
        )


def _disturbance(disturbance: DisturbanceConfig, env: EnvConfig, key: str) -> None:
    for item in fields(disturbance.sensing):
        _at_least(f"{key}.sensing.{item.name}", getattr(disturbance.sensing, item.name), 0)
    timestep = env.physics.timestep
    for name in ("delay", "motor_gain", "mass", "friction"):
        interval: Interval | None = getattr(disturbance, name)
        if interval is not None:
            _interval(f"{key}.{name}", interval.lower, interval.upper)
            check = _positive if name != "delay" else _not_negative
            check(f"{key}.{name}.lower", interval.lower)
    for name in ("lower", "upper"):
        _multiple(f"{key}.delay.{name}", getattr(disturbance.delay, name), timestep)
    _at_least(f"{key}.centre_of_mass", disturbance.centre_of_mass, 0)
    push, ground = disturbance.push, disturbance.ground
    _at_least(f"{key}.push.speed", push.speed, 0)
    _positive(f"{key}.push.interval", push.interval)
    _multiple(f"{key}.push.interval", push.interval, env.control_period)
    _at_least(f"{key}.ground.amplitude", ground.amplitude, 0)
    _positive(f"{key}.ground.cell", ground.cell)
    _positive(f"{key}.ground.period", ground.period)
    _multiple(f"{key}.ground.period", ground.period, ground.cell)
    cells = round(ground.period / ground.cell)
    _require(cells <= MAX_CELLS, f"{key}.ground.period", f"at most {MAX_CELLS} cells", cells)


def _multiple(key: str, value: float, step: float) -> None:
    steps = value / step
    _require(abs(steps - round(steps)) < 1e-6, key, f"a multiple of {step:g}", value)


def _verification(verification: VerificationConfig) -> None:
    key = "verification"
    _at_least(f"{key}.chunk", verification.chunk, 1)
    _in(f"{key}.on_failure", verification.on_failure, ("error", "report"))
    _at_least(f"{key}.points", verification.points, 2)
    for name in ("reach", "perturbation"):
        _positive(f"{key}.{name}", getattr(verification, name))
    for name in ("relative", "absolute"):
        _positive(f"{key}.integrator.{name}", getattr(verification.integrator, name))
    replay = verification.replay
    _at_least(f"{key}.replay.steps", replay.steps, 1)
    steer = replay.regulator
    _require(
        len(steer.forward) == len(steer.speeds) > 0 and steer.speeds == sorted(steer.speeds),
        f"{key}.replay.regulator.forward",
        "one share for each of the rising `speeds`",
        f"{steer.forward} at {steer.speeds}",
    )
    _at_least(f"{key}.replay.points", replay.points, 2)
    _at_least(f"{key}.replay.substeps", replay.substeps, 1)
    _positive(f"{key}.replay.timestep", replay.timestep)
    for name in ("settle", "fade"):
        _positive(f"{key}.replay.regulator.{name}", getattr(replay.regulator, name))


def _report(report: ReportConfig, protocols: Iterable[str], control_period: float) -> None:
    key, video = "report", report.video
    _require(bool(report.sections), f"{key}.sections", "at least one section", "none")
    absent = {*PROTOCOL_SECTIONS} - {*protocols}
    known = [name for name in SECTION_INPUTS if name not in absent]
    for name in report.sections:
        _in(f"{key}.sections", name, known)
    unique = len(set(report.sections)) == len(report.sections)
    _require(unique, f"{key}.sections", "each section once", report.sections)
    _in(f"{key}.video.renderer", video.renderer, RENDERERS)
    _positive(f"{key}.video.duration", video.duration)
    for name in ("width", "height"):  # H.264 stores colours at half the resolution
        size = getattr(video, name)
        _require(
            32 <= size <= 1920 and size % 2 == 0, f"{key}.video.{name}", "even, 32 to 1920", size
        )
    _at_least(f"{key}.video.frame_rate", video.frame_rate, 1)
    steps = 1.0 / (control_period * video.frame_rate)
    _require(
        steps >= 1 and abs(steps - round(steps)) < 1e-9,
        f"{key}.video.frame_rate",
        f"a divisor of the control rate ({1 / control_period:g} 1/s)",
        video.frame_rate,
    )
    _require(0 <= video.quality <= 51, f"{key}.video.quality", "0 to 51", video.quality)
    _at_least(f"{key}.video.seed", video.seed, 0)


def _ablation(ablation: AblationConfig) -> None:
    key = "ablation"
    for name in ablation.run:
        _in(f"{key}.run", name, ablation.variants)
    for name in ("run", "seeds", "commands"):
        values = getattr(ablation, name)
        unique = len(set(values)) == len(values) > 0
        _require(unique, f"{key}.{name}", "one or more, each once", values)
    for name in ("samples", "pretraining_samples", "check_every", "trials", "robots"):
        _at_least(f"{key}.{name}", getattr(ablation, name), 1)
