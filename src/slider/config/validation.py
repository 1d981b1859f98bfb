"""Rules between values; what a value may be by itself is in the types of the schema.

Each failure is one line. Stages get checked values and need none of this.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

from slider.config.checks import distinct, multiple, named, one_of, ordered, period, require
from slider.config.control import (
    ONBOARD,
    PAPER_LABELS,
    POLICY,
    POLICY_LABEL,
    SMOKE_AGENTS,
    AnyControl,
    MpcConfig,
)
from slider.config.disturbance import DisturbanceConfig
from slider.config.env import EnvConfig, PhysicsConfig
from slider.config.evaluation import (
    CaseConfig,
    EvaluationConfig,
    ProfileConfig,
    SeedBlock,
    SeedsConfig,
)
from slider.config.gait import Axis, GaitConfig, GridBlock, GridConfig, Posture, StepTime, axis_size
from slider.config.parameters import choose, parameters
from slider.config.report import ReportConfig
from slider.config.robot import LEG_DRIVES, LEG_JOINTS, RobotConfig
from slider.config.schema import Config
from slider.config.studies import ScalingConfig, StudyConfig
from slider.config.train import NetworkConfig, SelectionConfig, TrainConfig
from slider.config.verification import RegulatorConfig


def validate(config: Config) -> None:
    """Refuse values that do not fit together.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    check_robot(config.robot)
    check_gait(config.gait)
    check_env(config.env)
    check_trainings(config)
    check_controls(config.control, config.env)
    check_protocols(config)
    check_regulator(config.verification.replay.regulator)
    check_report(config.report, config.env.control_period)
    check_seeds(config)
    check_studies(config)


def check_robot(robot: RobotConfig) -> None:
    """Every joint and drive, ranges that are not empty, legs that reach, tags of what there is."""
    check_names("robot.joints", robot.joints, LEG_JOINTS)
    check_names("robot.drives", robot.drives, LEG_DRIVES)
    check_names("robot.gains", robot.gains, LEG_DRIVES)
    for name, joint in robot.joints.items():
        found = f"{joint.lower} and {joint.upper}"
        require(joint.lower < joint.upper, f"robot.joints.{name}", "lower < upper", found)
    length, knee = robot.geometry.leg_length, robot.virtual_knee
    reach = knee.thigh_length + knee.shank_length
    expected = f"thigh + shank longer than the leg ({length} m)"
    require(reach > length, "robot.virtual_knee", expected, reach)
    paths = [f"{item.path}." for item in parameters(robot)]
    for group in robot.provenance:
        known = any(path.startswith(f"{group}.") for path in paths)
        require(known, "robot.provenance", "keys below robot that hold numbers", group)


def check_names(key: str, found: Iterable[str], expected: Iterable[str]) -> None:
    """Exactly the expected ones, in any order."""
    found, expected = tuple(found), tuple(expected)
    require(set(found) == set(expected), key, ", ".join(expected), ", ".join(found))


MAX_GRID = 5000


def check_gait(gait: GaitConfig) -> None:
    """A grid that can be solved, and limits that leave room between them."""
    _grid(gait.grid)
    _step_time(gait.step_time)
    ordered("gait.touchdown.down", gait.touchdown.down_min, gait.touchdown.down_max)
    _posture(gait.posture)


def check_regulator(regulator: RegulatorConfig) -> None:
    """One share forwards for each speed."""
    shares, speeds = regulator.forward, regulator.speeds
    expected = "one share for each of the `speeds`"
    found = f"{shares} at {speeds}"
    key = "verification.replay.regulator.forward"
    require(len(shares) == len(speeds), key, expected, found)


def _grid(grid: GridConfig) -> None:
    size = _block("gait.grid", grid)
    size += sum(_block(f"gait.grid.extra[{i}]", block) for i, block in enumerate(grid.extra))
    require(size <= MAX_GRID, "gait.grid", f"at most {MAX_GRID} commands", size)


def _block(key: str, block: GridBlock) -> int:
    return _axis(f"{key}.vx", block.vx) * _axis(f"{key}.vy", block.vy) * len(block.yaw_rate)


def _axis(key: str, axis: Axis | list[float]) -> int:
    if isinstance(axis, Axis):
        possible = axis.start <= axis.stop
        require(possible, key, "start ≤ stop, or a list", f"{axis.start} > {axis.stop}")
    return axis_size(axis)


def _step_time(time: StepTime) -> None:
    key = "gait.step_time"
    ordered(key, time.lower, time.upper)
    within = time.lower <= time.value <= time.upper
    require(within, f"{key}.value", f"from {time.lower} to {time.upper} s", time.value)


def _posture(posture: Posture) -> None:
    key = "gait.posture"
    clearance = posture.clearance + posture.clearance_margin
    expected = f"with its margin less than swing_height ({posture.swing_height} m)"
    require(clearance < posture.swing_height, f"{key}.clearance", expected, clearance)
    ordered(f"{key}.knee", posture.knee_min, posture.knee_max)
    separation = posture.foot_separation_min, posture.foot_separation_max
    ordered(f"{key}.foot_separation", *separation)


MAX_CELLS = 400


def check_env(env: EnvConfig) -> None:
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
    check_names("env.action.scale", env.action.scale, LEG_JOINTS)
    possible = env.phase.enabled or env.action.offset == "nominal"
    require(possible, "env.action.offset", "nominal where there is no phase", env.action.offset)
    halt = env.phase.halt
    expected = f"a value ≥ {halt.below}"
    require(halt.above >= halt.below, "env.phase.halt.above", expected, halt.above)
    possible = env.phase.enabled or not (env.phase.mirror or halt.below > 0)
    require(possible, "env.phase", "a clock for mirror and halt", "none")


def check_disturbance(disturbance: DisturbanceConfig, env: EnvConfig, key: str) -> None:
    """Times that the simulation can hit, and ground that repeats."""
    for name in ("lower", "upper"):
        delay = getattr(disturbance.delay, name)
        multiple(f"{key}.delay.{name}", delay, env.physics.timestep)
    multiple(f"{key}.push.interval", disturbance.push.interval, env.control_period)
    ground = disturbance.ground
    multiple(f"{key}.ground.period", ground.period, ground.cell)
    cells = round(ground.period / ground.cell)
    require(cells <= MAX_CELLS, f"{key}.ground.period", f"at most {MAX_CELLS} cells", cells)


def check_trainings(config: Config) -> None:
    """All trainings and their disturbances."""
    walking, standing = config.train.walking, config.train.standing
    starts = standing.reset.reference_fraction
    expected = "0 (pre-training has no guide to start on)"
    require(starts == 0, "train.standing.reset.reference_fraction", expected, starts)
    for key, train in config.trainings.items():
        if train is not standing or config.train.pretraining:
            _same_network(walking.network, train.network, key)
        _train(train, config.env, key)
        _machine(train, config, key)
        check_disturbance(train.disturbance, config.env, f"{key}.disturbance")


def _machine(train: TrainConfig, config: Config, key: str) -> None:
    """Physics, device and precision that go together."""
    own = {
        "disturbance.ground.amplitude > 0": train.disturbance.ground.amplitude > 0,
        "env.sensing=onboard": config.env.sensing == "onboard",
    }
    for setting, chosen in own.items():
        possible = train.simulator == "mujoco" or not chosen
        require(possible, f"{key}.simulator", f"mujoco with {setting}", train.simulator)
    possible = train.simulator == "mujoco_warp" or train.device == "cpu"
    require(possible, f"{key}.device", f"cpu with simulator={train.simulator}", train.device)
    possible = train.device == "cuda" or train.gpus == 1
    require(possible, f"{key}.gpus", f"1 with device={train.device}", train.gpus)


def _same_network(walking: NetworkConfig, other: NetworkConfig, key: str) -> None:
    """One training goes on with the weights of the other."""
    for name in ("hidden", "activation"):
        own, found = getattr(walking, name), getattr(other, name)
        expected = f"{own}, as train.walking.network has it"
        require(found == own, f"{key}.network.{name}", expected, found)


def _train(train: TrainConfig, env: EnvConfig, key: str) -> None:
    length, least = train.episode_length, env.control_period
    require(length >= least, f"{key}.episode_length", f"a value ≥ {least}", length)
    _symmetry(train, env, f"{key}.ppo.symmetry")
    _mini_batches(train, key)
    _network(train.network, f"{key}.network")
    _selection(train.selection, env, f"{key}.selection")


def _selection(selection: SelectionConfig, env: EnvConfig, key: str) -> None:
    most = selection.fall_weight / 2
    expected = f"0 to {most:g}, half of fall_weight: a robot that fell costs most"
    possible = selection.flight_weight <= most
    require(possible, f"{key}.flight_weight", expected, selection.flight_weight)
    period(f"{key}.warm_up", selection.warm_up, selection.duration, env.control_period)


def _network(network: NetworkConfig, key: str) -> None:
    expected = f"at least {network.std_min} (std_min)"
    for name in ("std_max", "std_final"):
        bound = getattr(network, name)
        require(bound >= network.std_min, f"{key}.{name}", expected, bound)


def _symmetry(train: TrainConfig, env: EnvConfig, key: str) -> None:
    possible = train.ppo.symmetry == "none" or not env.phase.mirror
    expected = "none where env.phase.mirror shows the network left stance only"
    require(possible, key, expected, train.ppo.symmetry)


def _mini_batches(train: TrainConfig, key: str) -> None:
    batch, found = train.robots * train.steps_per_iteration, train.ppo.mini_batches
    size = "at least 2 samples (robots × steps_per_iteration)"
    require(batch > 1, f"{key}.robots", size, batch)
    expected = f"1 to {batch} (robots × steps_per_iteration)"
    require(found <= batch, f"{key}.ppo.mini_batches", expected, found)


LEAST_RATE = 200  # [Hz]
_TAKEN = (POLICY, *SMOKE_AGENTS, *PAPER_LABELS)  # names with a meaning of their own


def check_controls(controls: Mapping[str, AnyControl], env: EnvConfig) -> None:
    """Every controller beside the policy; people tell them apart by their labels."""
    named("control", controls)
    labels = {POLICY_LABEL: POLICY, **{label: name for name, label in PAPER_LABELS.items()}}
    for name, control in controls.items():
        key = f"control.{name}"
        require(name not in _TAKEN, key, f"another name than {', '.join(_TAKEN)}", name)
        require(not name.endswith(ONBOARD), key, f"a name that does not end with {ONBOARD}", name)
        _label(control.label, labels, f"{key}.label")
        labels[control.label] = name
        _control(control, env, key)


def _label(label: str, taken: Mapping[str, str], key: str) -> None:
    """One line of text that no other controller has; ``taken`` are labels with their owners."""
    require(bool(label.strip()), key, "a label", "none")
    require(label.isprintable() and label == label.strip(), key, "one line of text", repr(label))
    owner = taken.get(label)
    expected = f"another label than that of {owner} (a file without one inherits it)"
    require(label not in taken, key, expected, label)


def _control(control: AnyControl, env: EnvConfig, key: str) -> None:
    _substeps(control.substeps, env.physics, f"{key}.substeps")
    if isinstance(control, MpcConfig):
        step, planner = control.step, control.planner
        ordered(f"{key}.step", step.time_min, step.time)
        ordered(f"{key}.step", step.time, step.time_max)
        ordered(f"{key}.planner.width_min", planner.width_min, planner.width_max)
    if control.observer is not None:
        period = env.physics.timestep * control.substeps
        multiple(f"{key}.observer.delay", control.observer.delay, period)


def _substeps(substeps: int, physics: PhysicsConfig, key: str) -> None:
    """Ticks of the controller end with steps of the physics, and are short."""
    divides = physics.substeps % substeps == 0
    require(divides, key, f"a divisor of env.physics.substeps ({physics.substeps})", substeps)
    rate = 1 / (physics.timestep * substeps)
    expected = f"a control rate of at least {LEAST_RATE} Hz"
    require(rate > LEAST_RATE - 0.1, key, expected, f"{rate:.0f} Hz")


def check_protocols(config: Config) -> None:
    """All protocols and their disturbances; that of Table 1 has no profile."""
    named("protocols", config.protocols)
    expected = "none (the commands of Table 1 are constant; see protocols)"
    require(config.evaluation.profile is None, "evaluation.profile", expected, "one")
    for key, protocol in config.evaluations.items():
        _protocol(protocol, (POLICY, *config.control), key, config.env.control_period)
        check_disturbance(protocol.disturbance, config.env, f"{key}.disturbance")


def _protocol(
    protocol: EvaluationConfig, controllers: Iterable[str], key: str, control_period: float
) -> None:
    _commands(protocol, control_period, key)
    for name in protocol.controllers:
        one_of(f"{key}.controllers", name.removesuffix(ONBOARD), controllers)
    period(f"{key}.warm_up", protocol.warm_up, protocol.duration, control_period)


def _commands(protocol: EvaluationConfig, control_period: float, key: str) -> None:
    """Either constant ones or a profile."""
    speeds, profile = protocol.speeds, protocol.profile
    if profile is None:
        require(len(speeds) > 0, f"{key}.speeds", "at least one speed", "none")
        return
    require(not speeds, f"{key}.speeds", "none with a profile", speeds)
    _profile(profile, protocol.duration, control_period, f"{key}.profile")


def _profile(profile: ProfileConfig, duration: float, control_period: float, key: str) -> None:
    names = [case.name for case in profile.cases]
    distinct(f"{key}.cases", names, "each name once")
    possible = profile.rows == "cases" or len(names) == 1
    require(possible, f"{key}.cases", "one case where rows are its segments", names)
    shortest = max(profile.ramp, profile.warm_up) + control_period
    for index, case in enumerate(profile.cases):
        _segments(case, duration, shortest, f"{key}.cases[{index}].segments")


def _segments(case: CaseConfig, duration: float, shortest: float, key: str) -> None:
    distinct(key, [segment.name for segment in case.segments], "each name once")
    times = [segment.time for segment in case.segments]
    require(times[0] == 0.0, f"{key}[0].time", "0 s", times[0])
    for index, (start, end) in enumerate(pairwise(times), start=1):
        require(start < end, f"{key}[{index}].time", f"later than {start:g} s", end)
    expected = f"a control period longer than ramp and warm_up ({shortest:g} s)"
    for index, (start, end) in enumerate(pairwise([*times, duration])):
        length = end - start
        require(length >= shortest - 1e-9, f"{key}[{index}]", expected, f"{length:g} s")


def check_report(report: ReportConfig, control_period: float) -> None:
    """Frames of the videos; whoever lays out the jobs knows which sections there are."""
    _frame_rate(report.video.frame_rate, control_period, "report.video.frame_rate")


def _frame_rate(rate: int, control_period: float, key: str) -> None:
    """Every frame shows the end of a control step."""
    steps = 1.0 / (control_period * rate)
    expected = f"a divisor of the control rate ({1 / control_period:g} 1/s)"
    require(steps >= 1 and abs(steps - round(steps)) < 1e-9, key, expected, rate)


def check_studies(config: Config) -> None:
    """Variants and parameters that exist, and results to compare."""
    named("study", config.study)
    for name, study in config.study.items():
        key = f"study.{name}"
        named(f"{key}.variants", study.variants)
        for variant in study.run:
            one_of(f"{key}.run", variant, study.variants)
        if study.scaling is not None:
            _scaling(study.scaling, config, f"{key}.scaling")
        compared = study.gaits or study.evaluation is not None
        require(compared, key, "gaits=true or an evaluation", "neither")
        possible = study.gaits or study.starts is None
        require(possible, f"{key}.starts", "null without gaits", "starts")
        possible = study.evaluation is not None or study.training is None
        require(possible, f"{key}.training", "null without an evaluation", "a training")


def _scaling(scaling: ScalingConfig, config: Config, key: str) -> None:
    items = parameters(config.robot)
    for tag in scaling.provenance:
        one_of(f"{key}.provenance", tag, dict.fromkeys(item.provenance for item in items))
    expected = f"numbers of the robot tagged {' or '.join(scaling.provenance)}"
    for path in scaling.parameters:
        require(
            bool(choose(items, scaling.provenance, [path])), f"{key}.parameters", expected, path
        )


def check_seeds(config: Config) -> None:
    """Every evaluation is of one block; checkpoints and variants are chosen in development."""
    seeds = config.seeds
    _apart(seeds)
    for key, protocol in config.evaluations.items():
        blocks = (seeds.final, seeds.development)
        _within(f"{key}.seed", protocol.seed, protocol.trials, blocks)
    for name, study in config.study.items():
        _study(study, seeds, f"study.{name}")
    for key, train in config.trainings.items():
        _training(train, seeds, key)


def _apart(seeds: SeedsConfig) -> None:
    for name in ("final", "development"):
        block: SeedBlock = getattr(seeds, name)
        ordered(f"seeds.{name}", block.first, block.last)
    apart = seeds.final.last < seeds.development.first or seeds.development.last < seeds.final.first
    expected = f"no seed of seeds.development ({seeds.development})"
    require(apart, "seeds.final", expected, seeds.final)


def _within(key: str, first: int, trials: int, blocks: Sequence[SeedBlock]) -> None:
    """All trials draw from one of the blocks."""
    found = SeedBlock(first, first + trials - 1)
    inside = any(found.first in block and found.last in block for block in blocks)
    expected = f"seeds within {' or '.join(map(str, blocks))}"
    require(inside, key, expected, found)


def _study(study: StudyConfig, seeds: SeedsConfig, key: str) -> None:
    """Trained variants are there to be chosen from; other policies are only reported."""
    training, rollouts = study.training, study.evaluation
    if rollouts is not None:
        compared = training is not None and len(study.run) > 1
        blocks = (seeds.development,) if compared else (seeds.final, seeds.development)
        _within(f"{key}.evaluation.seed", rollouts.seed, rollouts.trials, blocks)
    for index, seed in enumerate(training.seeds if training else ()):
        _not_final(f"{key}.training.seeds[{index}]", seed, seeds)


def _training(train: TrainConfig, seeds: SeedsConfig, key: str) -> None:
    _not_final(f"{key}.seed", train.seed, seeds)
    _within(f"{key}.selection.seed", train.selection.seed, 1, (seeds.development,))


def _not_final(key: str, seed: int, seeds: SeedsConfig) -> None:
    """A training on the disturbed robots of a reported trial would know them."""
    require(seed not in seeds.final, key, f"none of seeds.final ({seeds.final})", seed)
