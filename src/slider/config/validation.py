"""Rules between values; what a value may be by itself is in the types of the schema.

Each failure is one line. Stages get checked values and need none of this.
"""

import json
import re
from collections.abc import Iterable, Mapping
from itertools import pairwise

import numpy as np

from slider.config.control import (
    ONBOARD,
    PAPER_LABELS,
    POLICY,
    POLICY_LABEL,
    SMOKE_AGENTS,
    AnyControl,
    MpcConfig,
)
from slider.config.convert import from_dict, to_dict
from slider.config.env import DisturbanceConfig, EnvConfig
from slider.config.evaluation import EvaluationConfig, ProfileConfig, SeedBlock, Segment
from slider.config.gait import Axis, GaitConfig, axis_size
from slider.config.gauge import AXES, FALLING
from slider.config.parameters import parameters
from slider.config.robot import LEG_JOINTS, Link, RobotConfig
from slider.config.schema import Config, StudyConfig
from slider.config.train import TrainConfig
from slider.config.tuning import setting, with_settings
from slider.core.errors import one_of, require

NAME = re.compile(r"[a-z][a-z0-9_]*")
"""Of a target, a file or a row: it reads the same to a shell, on any disk, in a table."""
MAX_GRID = 5000  # velocities
LEAST_RATE = 200  # of a controller [Hz]
_RESERVED = (POLICY, *SMOKE_AGENTS, *PAPER_LABELS)  # names with a meaning of their own


def validate(config: Config) -> None:
    """Refuse values that do not fit together.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    _robot(config.robot)
    _gait(config.gait)
    _tube(config)
    _env(config.env)
    _standing(config)
    _trainings(config)
    _controls(config.control, config.env)
    _protocols(config)
    _gauge(config)
    _tuning(config)
    regulator = config.verification.replay.regulator
    shares, speeds = regulator.forward, regulator.speeds
    key, expected = "verification.replay.regulator.forward", "one share for each of the `speeds`"
    require(len(shares) == len(speeds), key, expected, f"{shares} at {speeds}")
    _frame_rate(config.report.video.frame_rate, config.env.control_period)
    _seeds(config)
    _studies(config)


def _ordered(key: str, lower: float, upper: float) -> None:
    require(lower <= upper, key, "lower ≤ upper", f"{lower} > {upper}")


def _multiple(key: str, value: float, step: float) -> None:
    steps = value / step
    require(abs(steps - round(steps)) < 1e-6, key, f"a multiple of {step:g}", value)


def _warm_up(key: str, warm_up: float, duration: float, period: float) -> None:
    """A control period or more is left after the warm-up [s]."""
    latest = duration - period
    require(warm_up <= latest + 1e-9, f"{key}.warm_up", f"a time in [0, {latest:g}] s", warm_up)


def _distinct(key: str, names: list[str]) -> None:
    require(len(set(names)) == len(names), key, "each name once", names)


def _named(key: str, names: Iterable[str]) -> None:
    """Each a name that nobody must quote."""
    expected = "names of small letters, digits and _ after a letter"
    for name in names:
        require(NAME.fullmatch(name) is not None, key, expected, json.dumps(name))


def _complete(key: str, names: Iterable[str], expected: Iterable[str]) -> None:
    """Exactly the expected names, in any order."""
    names, expected = tuple(names), tuple(expected)
    require(set(names) == set(expected), key, ", ".join(expected), ", ".join(names))


def _robot(robot: RobotConfig) -> None:
    """Every joint and drive, ranges that are not empty, legs that reach, tags of parameters."""
    _complete("robot.joints", robot.joints, LEG_JOINTS)
    motors = dict.fromkeys(robot.leg_motors)
    _complete("robot.drives", robot.drives, motors)
    _complete("robot.gains", robot.gains, motors)
    for name, joint in robot.joints.items():
        bounds = f"{joint.lower} and {joint.upper}"
        require(joint.lower < joint.upper, f"robot.joints.{name}", "lower < upper", bounds)
    lateral = robot.geometry.hip[1]
    expected = "a sum of y > 0 m: left hips are on the left"
    require(lateral > 0.0, "robot.geometry.axes", expected, f"{lateral:g}")
    base, key = robot.links.base, "robot.links.base"
    require(base.com[1] == 0.0, f"{key}.com", "y = 0 m: left and right are alike", base.com[1])
    across, _, side = base.products
    expected = "Ixy = Iyz = 0 kg m²: left and right are alike"
    require(across == side == 0.0, f"{key}.products", expected, f"{across:g} and {side:g}")
    for name in vars(robot.links):
        _principal(f"robot.links.{name}", getattr(robot.links, name))
    length, knee = robot.geometry.leg_length, robot.virtual_knee
    reach = knee.thigh_length + knee.shank_length
    expected = f"thigh + shank longer than the leg ({length} m)"
    require(reach > length, "robot.virtual_knee", expected, reach)
    paths = [f"{item.path}." for item in parameters(robot)]
    for group in robot.provenance:
        tags_numbers = any(path.startswith(f"{group}.") for path in paths)
        require(tags_numbers, "robot.provenance", "keys below robot that hold numbers", group)


def _principal(key: str, link: Link) -> None:
    """Inertia of a rigid body: principal moments that are positive, none above the others' sum."""
    moments = np.linalg.eigvalsh(link.tensor)
    possible = moments[0] > 0.0 and 2 * moments[-1] <= moments.sum() * (1 + 1e-9)
    expected = "positive principal moments, none above the sum of the others"
    found = ", ".join(f"{moment:.4g}" for moment in moments)
    require(possible, f"{key}.products", expected, found)


def _gait(gait: GaitConfig) -> None:
    """A grid that can be solved, and limits that leave room between them."""
    size = 0
    extra = {f"gait.grid.extra[{index}]": block for index, block in enumerate(gait.grid.extra)}
    for key, block in {"gait.grid": gait.grid, **extra}.items():
        for name, axis in (("vx", block.vx), ("vy", block.vy)):
            if isinstance(axis, Axis):
                bounds = f"{axis.start} > {axis.stop}"
                possible = axis.start <= axis.stop
                require(possible, f"{key}.{name}", "start ≤ stop, or a list", bounds)
        size += axis_size(block.vx) * axis_size(block.vy) * len(block.yaw_rate)
    require(size <= MAX_GRID, "gait.grid", f"at most {MAX_GRID} velocities", size)
    time, key = gait.step_time, "gait.step_time"
    _ordered(key, time.lower, time.upper)
    within = time.lower <= time.value <= time.upper
    require(within, f"{key}.value", f"from {time.lower} to {time.upper} s", time.value)
    _ordered("gait.touchdown.down", gait.touchdown.down_min, gait.touchdown.down_max)
    posture, key = gait.posture, "gait.posture"
    clearance = posture.clearance + posture.clearance_margin
    expected = f"with its margin less than swing_height ({posture.swing_height} m)"
    require(clearance < posture.swing_height, f"{key}.clearance", expected, clearance)
    _ordered(f"{key}.knee", posture.knee_min, posture.knee_max)
    separation = posture.foot_separation_min, posture.foot_separation_max
    _ordered(f"{key}.foot_separation", *separation)


def _tube(config: Config) -> None:
    """Virtual thigh and shank share a tube whose centre and principal axis lie on the leg's."""
    tube, key = config.robot.links.tube, "robot.links.tube"
    if config.gait.dynamics == "knee":
        x, y, _ = tube.com
        expected = "x = y = 0 m with gait.dynamics=knee"
        require(x == y == 0.0, f"{key}.com", expected, f"x = {x}, y = {y}")
        products = ", ".join(map(str, tube.products))
        expected = "0, 0, 0 kg m² with gait.dynamics=knee"
        require(not any(tube.products), f"{key}.products", expected, products)


def _env(env: EnvConfig) -> None:
    """Steps that fill the control period, and a clock where something needs it."""
    period = env.physics.timestep * env.physics.substeps
    expected = f"timestep × substeps = control_period ({env.control_period} s)"
    require(abs(period - env.control_period) < 1e-9, "env.physics", expected, period)
    require(env.onboard is not None, "env.onboard", "sensors and estimator", "none")
    if env.onboard is not None:  # for the type checker
        estimator = env.onboard.estimator
        expected = f"a value > {estimator.lifted}"
        possible = estimator.loaded > estimator.lifted
        require(possible, "env.onboard.estimator.loaded", expected, estimator.loaded)
    _complete("env.action.scale", env.action.scale, LEG_JOINTS)
    offset, phase = env.action.offset, env.phase
    possible = phase.enabled or offset == "nominal"
    require(possible, "env.action.offset", "nominal where there is no phase", offset)
    least = phase.halt.below
    possible = phase.halt.above >= least
    require(possible, "env.phase.halt.above", f"a value ≥ {least}", phase.halt.above)
    possible = phase.enabled or not (phase.mirror or least > 0)
    require(possible, "env.phase", "a clock for mirror and halt", "none")


def _standing(config: Config) -> None:
    """A robot that stands has not failed."""
    height, terms = config.robot.geometry.standing_height, config.env.termination.terms
    least, key = terms.get("base_height", 0.0), "env.termination.terms.base_height"
    expected = f"less than {height:g} m, at which the robot stands"
    require(least < height, key, expected, least)


def _disturbance(
    disturbance: DisturbanceConfig, env: EnvConfig, key: str, curriculum: bool = True
) -> None:
    """Times that the simulation can hit; only trainings have a ``curriculum``."""
    possible = curriculum or not disturbance.terrain.curriculum
    require(possible, f"{key}.terrain.curriculum", "false outside trainings", "true")
    _multiple(f"{key}.delay.lower", disturbance.delay.lower, env.physics.timestep)
    _multiple(f"{key}.delay.upper", disturbance.delay.upper, env.physics.timestep)
    push = disturbance.push
    _multiple(f"{key}.push.duration", push.duration, env.control_period)
    _multiple(f"{key}.push.interval", push.interval, env.control_period)
    expected = f"less than its interval ({push.interval} s)"
    require(push.duration < push.interval, f"{key}.push.duration", expected, push.duration)


def _trainings(config: Config) -> None:
    """All trainings and their disturbances; all that follow one another have one network."""
    walking, standing = config.train.walking, config.train.standing
    starts = standing.reset.reference_fraction
    expected = "0 (pre-training has no guide to start on)"
    require(starts == 0, "train.standing.reset.reference_fraction", expected, starts)
    for key, train in config.trainings.items():
        if train is not standing or config.train.pretraining:
            for name in ("hidden", "activation"):
                own, other = getattr(walking.network, name), getattr(train.network, name)
                expected = f"{own}, as train.walking.network has it"
                require(other == own, f"{key}.network.{name}", expected, other)
        _train(train, config.env, key)
        _processor(train, key)
        _disturbance(train.disturbance, config.env, f"{key}.disturbance")


def _processor(train: TrainConfig, key: str) -> None:
    """Physics, ground and device that go together."""
    simulator, device = train.simulator, train.device
    possible = simulator == "mujoco" or train.disturbance.terrain.kinds == ["flat"]
    expected = "mujoco with disturbance.terrain"
    require(possible, f"{key}.simulator", expected, simulator)
    possible = simulator == "mujoco" or train.sensing == "true_state"
    require(possible, f"{key}.simulator", "mujoco with sensing=onboard", simulator)
    possible = simulator == "mujoco_warp" or device == "cpu"
    require(possible, f"{key}.device", f"cpu with simulator={simulator}", device)
    possible = device == "cuda" or train.gpus == 1
    require(possible, f"{key}.gpus", f"1 with device={device}", train.gpus)


def _train(train: TrainConfig, env: EnvConfig, key: str) -> None:
    """Episodes, batches, bounds of the action noise and checks that can be."""
    length, least = train.episode_length, env.control_period
    require(length >= least, f"{key}.episode_length", f"a value ≥ {least}", length)
    possible = train.ppo.symmetry == "none" or not env.phase.mirror
    expected = "none where env.phase.mirror shows the network left stance only"
    require(possible, f"{key}.ppo.symmetry", expected, train.ppo.symmetry)
    batch, mini_batches = train.robots * train.steps_per_iteration, train.ppo.mini_batches
    size = "at least 2 samples (robots × steps_per_iteration)"
    require(batch > 1, f"{key}.robots", size, batch)
    expected = f"1 to {batch} (robots × steps_per_iteration)"
    require(mini_batches <= batch, f"{key}.ppo.mini_batches", expected, mini_batches)
    least = train.network.std_min
    for name in ("std_max", "std_final"):
        bound = getattr(train.network, name)
        require(bound >= least, f"{key}.network.{name}", f"at least {least} (std_min)", bound)
    selection, key = train.selection, f"{key}.selection"
    most = selection.fall_weight / 2
    expected = f"0 to {most:g}, half of fall_weight: a robot that fell costs most"
    weight = selection.flight_weight
    require(weight <= most, f"{key}.flight_weight", expected, weight)
    _warm_up(key, selection.warm_up, selection.duration, env.control_period)


def _controls(controls: Mapping[str, AnyControl], env: EnvConfig) -> None:
    """Every controller beside the policy; people tell them apart by their labels."""
    _named("control", controls)
    labels = {POLICY_LABEL: POLICY, **{label: name for name, label in PAPER_LABELS.items()}}
    for name, control in controls.items():
        key, label = f"control.{name}", control.label
        expected = f"another name than {', '.join(_RESERVED)}"
        require(name not in _RESERVED, key, expected, name)
        require(not name.endswith(ONBOARD), key, f"a name that does not end with {ONBOARD}", name)
        require(bool(label.strip()), f"{key}.label", "a label", "none")
        one_line = label.isprintable() and label == label.strip()
        require(one_line, f"{key}.label", "one line of text", repr(label))
        owner = labels.setdefault(label, name)
        expected = f"another label than that of {owner} (a file without one inherits it)"
        require(owner == name, f"{key}.label", expected, label)
        _control(control, env, key)


def _control(control: AnyControl, env: EnvConfig, key: str) -> None:
    """Short ticks that end with steps of the physics, and limits in order."""
    physics = env.physics
    divides = physics.substeps % control.substeps == 0
    expected = f"a divisor of env.physics.substeps ({physics.substeps})"
    require(divides, f"{key}.substeps", expected, control.substeps)
    tick = physics.timestep * control.substeps
    expected = f"a control rate of at least {LEAST_RATE} Hz"
    possible = 1 / tick > LEAST_RATE - 0.1
    require(possible, f"{key}.substeps", expected, f"{1 / tick:.0f} Hz")
    if isinstance(control, MpcConfig):
        step, planner = control.step, control.planner
        _ordered(f"{key}.step", step.time_min, step.time)
        _ordered(f"{key}.step", step.time, step.time_max)
        _ordered(f"{key}.planner.width_min", planner.width_min, planner.width_max)
    if control.observer is not None:
        _multiple(f"{key}.observer.delay", control.observer.delay, tick)


def _protocols(config: Config) -> None:
    """All protocols and their disturbances; that of Table 1 has no profile."""
    _named("protocols", config.protocols)
    expected = "none (the velocities of Table 1 are constant; see protocols)"
    require(config.evaluation.profile is None, "evaluation.profile", expected, "one")
    for key, protocol in config.evaluations.items():
        _protocol(protocol, (POLICY, *config.control), key, config.env.control_period)
        _disturbance(protocol.disturbance, config.env, f"{key}.disturbance", curriculum=False)


def _protocol(
    protocol: EvaluationConfig, controllers: Iterable[str], key: str, period: float
) -> None:
    """Either constant speeds or a profile, of controllers that there are."""
    speeds, profile = protocol.speeds, protocol.profile
    if profile is None:
        require(len(speeds) > 0, f"{key}.speeds", "at least one speed", "none")
    else:
        require(not speeds, f"{key}.speeds", "none with a profile", speeds)
        _profile(profile, protocol.duration, period, f"{key}.profile.cases")
    for name in protocol.controllers:
        one_of(f"{key}.controllers", name.removesuffix(ONBOARD), controllers)
    _warm_up(key, protocol.warm_up, protocol.duration, period)


def _gauge(config: Config) -> None:
    """Controllers and axes that there are, levels that get harder, policies with names."""
    gauge, key = config.gauge, "gauge"
    _named(f"{key}.policies", gauge.policies)
    for name in gauge.policies:
        taken = name in (*_RESERVED, *config.control) or name.endswith(ONBOARD)
        expected = f"a name that no controller has and that does not end with {ONBOARD}"
        require(not taken, f"{key}.policies", expected, name)
    for name in gauge.controllers:
        there = (POLICY, *config.control, *gauge.policies)
        one_of(f"{key}.controllers", name.removesuffix(ONBOARD), there)
    for axis in gauge.axes:
        one_of(f"{key}.axes", axis, AXES)
    for name, values in vars(gauge.scales).items():
        ordered = sorted(set(values), reverse=name in FALLING)
        expected = "falling values" if name in FALLING else "rising values"
        require(ordered == values, f"{key}.scales.{name}", expected, values)
    for index, delay in enumerate(gauge.scales.delay):
        _multiple(f"{key}.scales.delay[{index}]", delay, config.env.physics.timestep)
    _disturbance(gauge.disturbance, config.env, f"{key}.disturbance", curriculum=False)
    period, push = config.env.control_period, gauge.disturbance.push
    least = push.interval + push.duration if "push" in gauge.axes else period
    expected = f"at least {least:g} s, with a push" if "push" in gauge.axes else f"at least {least}"
    require(gauge.duration >= least, f"{key}.duration", expected, gauge.duration)
    _multiple(f"{key}.duration", gauge.duration, period)


def _tuning(config: Config) -> None:
    """Settings that there are, with ranges that they may have."""
    for name, space in config.tuning.spaces.items():
        controller = name.removesuffix(ONBOARD)
        one_of("tuning.spaces", controller, config.control)
        typed = config.control[controller]
        control = to_dict(typed)
        for dotted, bounds in space.items():
            key = f"tuning.spaces.{name}"
            present = setting(control, dotted)
            there = present is not None
            require(there, key, f"names of numbers of control.{controller}", dotted)
            for end in (bounds.lower, bounds.upper):
                value = round(end) if isinstance(present, int) else end
                from_dict(type(typed), with_settings(control, {dotted: value}), key)
            _ordered(f"{key}.{dotted}", bounds.lower, bounds.upper)
            above = not bounds.log or bounds.lower > 0
            require(above, f"{key}.{dotted}.lower", "more than 0 with log", bounds.lower)


def _profile(profile: ProfileConfig, duration: float, period: float, key: str) -> None:
    names = [case.name for case in profile.cases]
    _distinct(key, names)
    possible = profile.rows == "cases" or len(names) == 1
    require(possible, key, "one case where rows are its segments", names)
    shortest = max(profile.ramp, profile.warm_up) + period
    for index, case in enumerate(profile.cases):
        _segments(case.segments, duration, shortest, f"{key}[{index}].segments")


def _segments(segments: list[Segment], duration: float, shortest: float, key: str) -> None:
    """Names each once, and starts that rise from 0 s with room for ramp and warm-up [s]."""
    _distinct(key, [segment.name for segment in segments])
    times = [segment.time for segment in segments]
    require(times[0] == 0.0, f"{key}[0].time", "0 s", times[0])
    for index, (start, end) in enumerate(pairwise(times), start=1):
        require(start < end, f"{key}[{index}].time", f"later than {start:g} s", end)
    expected = f"a control period longer than ramp and warm_up ({shortest:g} s)"
    for index, (start, end) in enumerate(pairwise([*times, duration])):
        length = end - start
        require(length >= shortest - 1e-9, f"{key}[{index}]", expected, f"{length:g} s")


def _frame_rate(rate: int, period: float) -> None:
    """Every frame of a video shows the end of a control step."""
    steps = 1.0 / (period * rate)
    expected = f"a divisor of the control rate ({1 / period:g} 1/s)"
    possible = steps >= 1 and abs(steps - round(steps)) < 1e-9
    require(possible, "report.video.frame_rate", expected, rate)


def _seeds(config: Config) -> None:
    """Every evaluation is of one block; checkpoints and variants are chosen in development."""
    final, development = config.seeds.final, config.seeds.development
    _ordered("seeds.final", final.first, final.last)
    _ordered("seeds.development", development.first, development.last)
    apart = final.last < development.first or development.last < final.first
    require(apart, "seeds.final", f"no seed of seeds.development ({development})", final)
    for key, protocol in config.evaluations.items():
        _within(f"{key}.seed", protocol.seed, protocol.trials, final, development)
    _within("gauge.seed", config.gauge.seed, config.gauge.trials, final, development)
    _within("tuning.seed", config.tuning.seed, 1, development)
    for name, study in config.study.items():
        key, training, rollouts = f"study.{name}", study.training, study.evaluation
        if rollouts is not None:
            # Trained variants are there to be chosen from; other policies are only reported.
            compared = training is not None and len(study.run) > 1
            blocks = (development,) if compared else (final, development)
            _within(f"{key}.evaluation.seed", rollouts.seed, rollouts.trials, *blocks)
        for index, seed in enumerate(training.seeds if training else ()):
            _not_final(f"{key}.training.seeds[{index}]", seed, final)
    for key, train in config.trainings.items():
        _not_final(f"{key}.seed", train.seed, final)
        _within(f"{key}.selection.seed", train.selection.seed, 1, development)


def _within(key: str, first: int, trials: int, *blocks: SeedBlock) -> None:
    """All trials draw from one of the blocks."""
    drawn = SeedBlock(first, first + trials - 1)
    inside = any(drawn.first in block and drawn.last in block for block in blocks)
    require(inside, key, f"seeds within {' or '.join(map(str, blocks))}", drawn)


def _not_final(key: str, seed: int, final: SeedBlock) -> None:
    """A training must not see the disturbed robots of a reported trial."""
    require(seed not in final, key, f"none of seeds.final ({final})", seed)


def _studies(config: Config) -> None:
    """Variants that exist, and results to compare."""
    _named("study", config.study)
    for name, study in config.study.items():
        key = f"study.{name}"
        _named(f"{key}.variants", study.variants)
        for variant in study.run:
            one_of(f"{key}.run", variant, study.variants)
        _study(study, key)


def _study(study: StudyConfig, key: str) -> None:
    compared = study.gaits or study.evaluation is not None
    require(compared, key, "gaits=true or an evaluation", "neither")
    possible = study.gaits or study.starts is None
    require(possible, f"{key}.starts", "null without gaits", "starts")
    possible = study.evaluation is not None or study.training is None
    require(possible, f"{key}.training", "null without an evaluation", "a training")
