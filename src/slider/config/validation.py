"""Rules between groups of values; the types of the schema have those within one.

Each failure is one line. Stages get checked values and need none of this.
"""

import json
import re
from collections.abc import Iterable
from itertools import pairwise

from slider.config.control import ONBOARD, PAPER_LABELS, POLICY, POLICY_LABEL, SMOKE_AGENTS
from slider.config.convert import from_dict, setting, to_dict, with_settings
from slider.config.env import EnvConfig
from slider.config.evaluation import AXES, EvaluationConfig, GaugeConfig, SeedBlock
from slider.config.gait import axis_size
from slider.config.parameters import parameters
from slider.config.robot import BELOW_HIP, HIP_JOINTS, LEAST_BEND, RobotConfig
from slider.config.schema import Config
from slider.config.train import TrainConfig
from slider.core.errors import one_of, require

NAME = re.compile(r"[a-z][a-z0-9_]*")
"""Of a target, a file or a row: it reads the same to a shell, on any disk, in a table."""
_MAX_GRID = 5000  # velocities
_LEAST_RATE = 200  # of a controller [Hz]
_RESERVED = (POLICY, *SMOKE_AGENTS, *PAPER_LABELS)  # names with a meaning of their own


def validate(config: Config) -> None:
    """Refuse values that do not fit together.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    _robot(config.robot)
    grid = config.gait.grid
    sizes = (axis_size(b.vx) * axis_size(b.vy) * len(b.yaw_rate) for b in (grid, *grid.extra))
    size = sum(sizes)
    require(size <= _MAX_GRID, "gait.grid", f"at most {_MAX_GRID} velocities", size)
    if config.robot.virtual_knee is None:  # gaits are in the leg's own coordinates
        for name, value in ("kinematic_map", "exact"), ("dynamics", "prismatic"):
            found, expected = getattr(config.gait, name), f"{value} without robot.virtual_knee"
            require(found == value, f"gait.{name}", expected, found)
    elif config.gait.dynamics == "knee":  # virtual thigh and shank share a tube
        tube = config.robot.links.tube
        placed = (*tube.com[:2], *tube.products)
        expected = "com x and y, and products, of 0 with gait.dynamics=knee"
        require(not any(placed), "robot.links.tube", expected, f"{placed}")
    _env(config.env)
    height, terms = config.robot.geometry.standing_height, config.env.termination.terms
    least, key = terms.get("base_height", 0.0), "env.termination.terms.base_height"
    require(least < height, key, f"less than {height:g} m, at which the robot stands", least)
    _trainings(config)
    _controls(config)
    _named("protocols", config.protocols)
    expected = "none (the velocities of Table 1 are constant; see protocols)"
    require(config.evaluation.profile is None, "evaluation.profile", expected, "one")
    for key, protocol in config.evaluations.items():
        _protocol(protocol, config, key)
    _second_engine(config)
    _gauge(config)
    _tuning(config)
    steps = 1.0 / (config.env.control_period * config.report.video.frame_rate)
    possible = steps >= 1 and abs(steps - round(steps)) < 1e-9
    expected = f"a divisor of the control rate ({1 / config.env.control_period:g} 1/s)"
    found = config.report.video.frame_rate
    require(possible, "report.video.frame_rate", expected, found)
    _seeds(config)
    _named("study", config.study)
    for name, study in config.study.items():
        _named(f"study.{name}.variants", study.variants)
        for variant in study.run:
            one_of(f"study.{name}.run", variant, study.variants)


def _multiple(key: str, value: float, step: float) -> None:
    steps = value / step
    require(abs(steps - round(steps)) < 1e-6, key, f"a multiple of {step:g}", value)


def _warm_up(key: str, warm_up: float, duration: float, period: float) -> None:
    """A control period or more is left after the warm-up [s]."""
    latest = duration - period
    require(warm_up <= latest + 1e-9, f"{key}.warm_up", f"a time in [0, {latest:g}] s", warm_up)


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
    """Every joint and drive, legs that reach, tags of parameters."""
    geometry, virtual, motors = robot.geometry, robot.virtual_knee, dict.fromkeys(robot.leg_motors)
    for name in ("capstan", "virtual_knee"):
        possible = geometry.knee is None or getattr(robot, name) is None
        require(possible, f"robot.{name}", "null where the leg has a knee", "one")
    _complete("robot.joints", robot.joints, geometry.leg_joints)
    _complete("robot.drives", robot.drives, motors)
    _complete("robot.gains", robot.gains, motors)
    lateral, expected = geometry.hip[1], "a sum of y > 0 m: left hips are on the left"
    require(lateral > 0.0, "robot.geometry.axes", expected, f"{lateral:g}")
    if virtual is not None:
        expected = "null where hip_pitch is not the last of geometry.axes.order"
        require(geometry.axes.order[-1] == "hip_pitch", "robot.virtual_knee", expected, "one")
        reach = virtual.thigh_length + virtual.shank_length
        expected = f"thigh + shank longer than the leg ({geometry.leg_length} m)"
        require(reach > geometry.leg_length, "robot.virtual_knee", expected, reach)
    if geometry.knee is not None:
        (x, _, z), length = geometry.knee, geometry.leg_length
        bent = abs(x) >= LEAST_BEND * length and -length < z < 0.0
        expected = f"z between hip and ankle, x of {LEAST_BEND:.0%} of leg_length or more: bent"
        require(bent, "robot.geometry.knee", expected, list(geometry.knee))
    paths = [item.path for item in parameters(robot)]
    paths += [f"geometry.axes.{name}" for name in vars(geometry.axes)]
    for group in robot.provenance:
        tags_numbers = any(f"{path}.".startswith(f"{group}.") for path in paths)
        require(tags_numbers, "robot.provenance", "keys below robot that hold numbers", group)


def _env(env: EnvConfig) -> None:
    """Steps that fill the control period, and a clock where something needs it."""
    timestep = env.physics.timestep
    period = timestep * env.physics.substeps
    expected = f"timestep × substeps = control_period ({env.control_period} s)"
    require(abs(period - env.control_period) < 1e-9, "env.physics", expected, period)
    settling = env.physics.contact.time_constant
    expected = f"two timesteps ({2 * timestep} s) or more, as MuJoCo needs"
    possible = settling > 2 * timestep - 1e-9
    require(possible, "env.physics.contact.time_constant", expected, settling)
    require(env.onboard is not None, "env.onboard", "sensors and estimator", "none")
    _complete("env.action.scale", env.action.scale, HIP_JOINTS + BELOW_HIP)
    offset, phase = env.action.offset, env.phase
    possible = phase.enabled or offset == "nominal"
    require(possible, "env.action.offset", "nominal where there is no phase", offset)
    possible = phase.enabled or not (phase.mirror or phase.halt.below > 0)
    require(possible, "env.phase", "a clock for mirror and halt", "none")


def _disturbance(
    owner: TrainConfig | EvaluationConfig | GaugeConfig, env: EnvConfig, key: str
) -> None:
    """Times that the simulation can hit; only trainings have a curriculum."""
    disturbance, key = owner.disturbance, f"{key}.disturbance"
    possible = isinstance(owner, TrainConfig) or not disturbance.terrain.curriculum
    require(possible, f"{key}.terrain.curriculum", "false outside trainings", "true")
    _multiple(f"{key}.delay.lower", disturbance.delay.lower, env.physics.timestep)
    _multiple(f"{key}.delay.upper", disturbance.delay.upper, env.physics.timestep)
    _multiple(f"{key}.push.duration", disturbance.push.duration, env.control_period)
    _multiple(f"{key}.push.interval", disturbance.push.interval, env.control_period)


def _trainings(config: Config) -> None:
    """All trainings; all that follow one another have one network."""
    walking, standing = config.train.walking, config.train.standing
    starts, key = standing.reset.reference_fraction, "train.standing.reset.reference_fraction"
    require(starts == 0, key, "0 (pre-training has no guide to start on)", starts)
    for key, train in config.trainings.items():
        if train is not standing or config.train.pretraining:
            for name in ("hidden", "activation"):
                own, other = getattr(walking.network, name), getattr(train.network, name)
                expected = f"{own}, as train.walking.network has it"
                require(other == own, f"{key}.network.{name}", expected, other)
        _train(train, config.env, key)
        _disturbance(train, config.env, key)


def _train(train: TrainConfig, env: EnvConfig, key: str) -> None:
    """Physics and device that go together; episodes and batches that can be."""
    if train.simulator == "mujoco_warp":
        flat = train.disturbance.terrain.kinds == ["flat"] and train.sensing == "true_state"
        expected = "mujoco with disturbance.terrain or sensing=onboard"
        require(flat, f"{key}.simulator", expected, train.simulator)
    else:
        expected = f"cpu with simulator={train.simulator}"
        require(train.device == "cpu", f"{key}.device", expected, train.device)
    length, least = train.episode_length, env.control_period
    require(length >= least, f"{key}.episode_length", f"a value ≥ {least}", length)
    possible = train.ppo.symmetry == "none" or not env.phase.mirror
    expected = "none where env.phase.mirror shows the network left stance only"
    require(possible, f"{key}.ppo.symmetry", expected, train.ppo.symmetry)
    batch, mini_batches = train.robots * train.steps_per_iteration, train.ppo.mini_batches
    expected = "at least 2 samples (robots × steps_per_iteration)"
    require(batch > 1, f"{key}.robots", expected, batch)
    expected = f"1 to {batch} (robots × steps_per_iteration)"
    require(mini_batches <= batch, f"{key}.ppo.mini_batches", expected, mini_batches)
    selection = train.selection
    _warm_up(f"{key}.selection", selection.warm_up, selection.duration, env.control_period)


def _controls(config: Config) -> None:
    """Names and labels that tell controllers apart; ticks that end with steps of the physics."""
    _named("control", config.control)
    physics = config.env.physics
    labels = {POLICY_LABEL: POLICY, **{label: name for name, label in PAPER_LABELS.items()}}
    for name, control in config.control.items():
        key, label = f"control.{name}", control.label
        expected = f"another name than {', '.join(_RESERVED)}"
        require(name not in _RESERVED, key, expected, name)
        require(not name.endswith(ONBOARD), key, f"a name that does not end with {ONBOARD}", name)
        one_line = bool(label) and label.isprintable() and label == label.strip()
        require(one_line, f"{key}.label", "one line of text", repr(label))
        owner = labels.setdefault(label, name)
        expected = f"another label than that of {owner} (a file without one inherits it)"
        require(owner == name, f"{key}.label", expected, label)
        tick = physics.timestep * control.substeps
        possible = physics.substeps % control.substeps == 0 and 1 / tick > _LEAST_RATE - 0.1
        expected = f"a divisor of env.physics.substeps ({physics.substeps})"
        expected += f" for a control rate of at least {_LEAST_RATE} Hz"
        require(possible, f"{key}.substeps", expected, control.substeps)
        if control.observer is not None:
            _multiple(f"{key}.observer.delay", control.observer.delay, tick)


def _protocol(protocol: EvaluationConfig, config: Config, key: str) -> None:
    """Either constant speeds or a profile, of controllers that there are."""
    period = config.env.control_period
    speeds, profile = protocol.speeds, protocol.profile
    if profile is None:
        require(len(speeds) > 0, f"{key}.speeds", "at least one speed", "none")
    else:
        require(not speeds, f"{key}.speeds", "none with a profile", speeds)
        names, cases = [case.name for case in profile.cases], f"{key}.profile.cases"
        possible = profile.rows == "cases" or len(names) == 1
        require(possible, cases, "one case where rows are its segments", names)
        shortest = max(profile.ramp, profile.warm_up) + period
        expected = f"a control period longer than ramp and warm_up ({shortest:g} s)"
        for number, case in enumerate(profile.cases):
            times = [*(segment.time for segment in case.segments), protocol.duration]
            for index, (start, end) in enumerate(pairwise(times)):
                place, length = f"{cases}[{number}].segments[{index}]", end - start
                require(length >= shortest - 1e-9, place, expected, f"{length:g} s")
    for name in protocol.controllers:
        one_of(f"{key}.controllers", name.removesuffix(ONBOARD), (POLICY, *config.control))
    _warm_up(key, protocol.warm_up, protocol.duration, period)
    _disturbance(protocol, config.env, key)


def _second_engine(config: Config) -> None:
    """Whole steps of Drake in a step of MuJoCo, constant speeds, controllers of the protocol."""
    engine, key = config.second_engine, "second_engine"
    _multiple("env.physics.timestep", config.env.physics.timestep, engine.timestep)
    constant = engine.protocol.profile is None
    require(constant, f"{key}.protocol.profile", "null: constant speeds", "a profile")
    for name in engine.friction_controllers:
        one_of(f"{key}.friction_controllers", name, engine.protocol.controllers)


def _gauge(config: Config) -> None:
    """Controllers and axes that there are, policies with names, times that can be."""
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
    for index, delay in enumerate(gauge.scales.delay):
        _multiple(f"{key}.scales.delay[{index}]", delay, config.env.physics.timestep)
    _disturbance(gauge, config.env, key)
    period, push = config.env.control_period, gauge.disturbance.push
    least = push.interval + push.duration if "push" in gauge.axes else period
    expected = f"at least {least:g} s, with a push" if "push" in gauge.axes else f"at least {least}"
    require(gauge.duration >= least, f"{key}.duration", expected, gauge.duration)
    _multiple(f"{key}.duration", gauge.duration, period)


def _tuning(config: Config) -> None:
    """Settings that there are, with ranges that they may have."""
    for name, space in config.tuning.spaces.items():
        key, controller = f"tuning.spaces.{name}", name.removesuffix(ONBOARD)
        one_of("tuning.spaces", controller, config.control)
        typed = config.control[controller]
        control = to_dict(typed)
        for dotted, bounds in space.items():
            present = setting(control, dotted)
            expected = f"names of numbers of control.{controller}"
            require(present is not None, key, expected, dotted)
            for end in (bounds.lower, bounds.upper):
                value = round(end) if isinstance(present, int) else end
                from_dict(type(typed), with_settings(control, {dotted: value}), key)


def _seeds(config: Config) -> None:
    """Every evaluation is of one block; checkpoints and variants are chosen in development."""
    final, development = config.seeds.final, config.seeds.development
    apart = final.last < development.first or development.last < final.first
    require(apart, "seeds.final", f"no seed of seeds.development ({development})", final)
    for key, protocol in config.evaluations.items():
        _within(f"{key}.seed", protocol.seed, protocol.trials, final, development)
    _within("gauge.seed", config.gauge.seed, config.gauge.trials, final, development)
    _within("tuning.seed", config.tuning.seed, 2, development)
    # A training must not see the disturbed robots of a reported trial.
    trained = {f"{key}.seed": train.seed for key, train in config.trainings.items()}
    for name, study in config.study.items():
        key, training, rollouts = f"study.{name}", study.training, study.evaluation
        if rollouts is not None:
            # Trained variants are there to be chosen from; other policies are only reported.
            compared = training is not None and len(study.run) > 1
            blocks = (development,) if compared else (final, development)
            _within(f"{key}.evaluation.seed", rollouts.seed, rollouts.trials, *blocks)
        seeds = enumerate(training.seeds if training else ())
        trained |= {f"{key}.training.seeds[{index}]": seed for index, seed in seeds}
    for key, seed in trained.items():
        require(seed not in final, key, f"none of seeds.final ({final})", seed)
    for key, train in config.trainings.items():
        _within(f"{key}.selection.seed", train.selection.seed, 1, development)


def _within(key: str, first: int, trials: int, *blocks: SeedBlock) -> None:
    """All trials draw from one of the blocks."""
    last = first + trials - 1
    inside = any(first in block and last in block for block in blocks)
    require(inside, key, f"seeds within {' or '.join(map(str, blocks))}", f"{first} to {last}")
