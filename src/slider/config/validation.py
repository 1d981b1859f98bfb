"""Rules across groups of the configuration; rules within a group belong to its type."""

from itertools import pairwise

from slider.config.control import ONBOARD, POLICY, RESERVED
from slider.config.convert import from_dict, setting, to_dict, with_settings
from slider.config.schema import Config
from slider.core.errors import one_of, require


def validate(config: Config) -> None:
    """Raise a ``UserError`` about the first value that is inconsistent with the others."""
    gait, robot = config.gait, config.robot
    if robot.virtual_knee is None:  # gaits are in the leg's own coordinates
        for name, value in ("kinematic_map", "exact"), ("dynamics", "prismatic"):
            found, expected = getattr(gait, name), f"{value} without robot.virtual_knee"
            require(found == value, f"gait.{name}", expected, found)
    elif gait.dynamics == "knee":  # virtual thigh and shank share a tube
        placed = (*robot.links.tube.com[:2], *robot.links.tube.products)
        expected = "com x and y, and products, of 0 with gait.dynamics=knee"
        require(not any(placed), "robot.links.tube", expected, placed)
    height, key = robot.geometry.standing_height, "env.termination.terms.base_height"
    least = config.env.termination.terms.get("base_height", 0.0)
    require(least < height, key, f"less than {height:g} m, at which the robot stands", least)
    _simulations(config)
    _evaluations(config)
    _seeds(config)


def _simulations(config: Config) -> None:
    physics, period, walking = config.env.physics, config.env.control_period, config.train.walking
    require(config.env.onboard is not None, "env.onboard", "sensors and estimator", "none")
    step, drake = physics.timestep, config.second_engine.timestep
    possible = abs(step / drake - round(step / drake)) < 1e-6
    require(possible, "env.physics.timestep", f"a multiple of {drake:g}", step)
    for key, train in config.trainings.items():
        for name in ("hidden", "activation") if key == "finetuning" else ():
            own, found = (getattr(item.network, name) for item in (walking, train))
            expected = f"{own}, as train.walking.network has it"
            require(found == own, f"{key}.network.{name}", expected, found)
        length, check = train.episode_length, train.selection
        require(length >= period, f"{key}.episode_length", f"a value ≥ {period}", length)
        latest, expected = check.duration - period, f"a time in [0, {check.duration - period:g}] s"
        require(check.warm_up <= latest + 1e-9, f"{key}.selection.warm_up", expected, check.warm_up)
    for key, control in ((f"control.{name}", item) for name, item in config.control.items()):
        n, tick = physics.substeps, physics.timestep * control.substeps
        possible = n % control.substeps == 0 and 1 / tick > 199.9
        expected = f"a divisor of env.physics.substeps ({n}) for a control rate of at least 200 Hz"
        require(possible, f"{key}.substeps", expected, control.substeps)
        delay = control.observer.delay if control.observer else 0.0
        possible = abs(delay / tick - round(delay / tick)) < 1e-6
        require(possible, f"{key}.observer.delay", f"a multiple of {tick:g}", delay)


def _evaluations(config: Config) -> None:
    period, known, gauge = config.env.control_period, (POLICY, *config.control), config.gauge
    expected = "none (the velocities of Table 1 are constant; see protocols)"
    require(config.evaluation.profile is None, "evaluation.profile", expected, "one")
    studies = {f"study.{n}.evaluation": s.evaluation for n, s in config.study.items()}
    owners = config.evaluations | {"gauge": gauge} | {k: v for k, v in studies.items() if v}
    for key, owner in owners.items():
        for name in owner.controllers:
            exported = gauge.policies if owner is gauge else ()
            one_of(f"{key}.controllers", name.removesuffix(ONBOARD), (*known, *exported))
    for key, protocol in config.evaluations.items():
        latest, found = protocol.duration - period, protocol.warm_up
        require(found <= latest + 1e-9, f"{key}.warm_up", f"a time in [0, {latest:g}] s", found)
        profile, cases = protocol.profile, protocol.profile.cases if protocol.profile else []
        require(bool(protocol.speeds or cases), f"{key}.speeds", "at least one speed", "none")
        shortest = max(profile.ramp, profile.warm_up) + period if profile else 0.0
        expected = f"a control period longer than ramp and warm_up ({shortest:g} s)"
        for number, case in enumerate(cases):
            times = [*(segment.time for segment in case.segments), protocol.duration]
            for index, length in enumerate(end - start for start, end in pairwise(times)):
                place = f"{key}.profile.cases[{number}].segments[{index}]"
                require(length >= shortest - 1e-9, place, expected, f"{length:g} s")
    for name in (engine := config.second_engine).friction_controllers:
        one_of("second_engine.friction_controllers", name, engine.protocol.controllers)
    for name in gauge.policies:
        expected = f"a name that no controller has and that does not end with {ONBOARD}"
        possible = name not in (*RESERVED, *known) and not name.endswith(ONBOARD)
        require(possible, "gauge.policies", expected, name)
    rate, found, key = 1 / period, config.report.video.frame_rate, "report.video.frame_rate"
    possible = abs(rate / found - round(rate / found)) < 1e-9
    require(possible, key, f"a divisor of the control rate ({rate:g} 1/s)", found)
    for name, space in config.tuning.spaces.items():
        key, controller = f"tuning.spaces.{name}", name.removesuffix(ONBOARD)
        one_of("tuning.spaces", controller, config.control)
        cls, values = type(config.control[controller]), to_dict(config.control[controller])
        for dotted, bounds in space.items():
            present, expected = setting(values, dotted), f"names of numbers of control.{controller}"
            require(present is not None, key, expected, dotted)
            for end in (bounds.lower, bounds.upper):
                value = round(end) if isinstance(present, int) else end
                from_dict(cls, with_settings(values, {dotted: value}), key)


def _seeds(config: Config) -> None:
    """Each evaluation uses one block; checkpoints and variants are selected in development."""
    chosen, final, trainings = [config.seeds.development], config.seeds.final, config.trainings
    both = [final, *chosen]
    drawn = {key: (p.seed, p.trials, both) for key, p in config.evaluations.items()}
    drawn |= {"gauge": (config.gauge.seed, config.gauge.trials, both)}
    drawn |= {"tuning": (config.tuning.seed, 2, chosen)}
    drawn |= {f"{key}.selection": (t.selection.seed, 1, chosen) for key, t in trainings.items()}
    trained = {f"{key}.seed": t.seed for key, t in trainings.items()}  # must not be final seeds
    for key, study in ((f"study.{name}", study) for name, study in config.study.items()):
        seeds = enumerate(study.training.seeds if study.training else [])
        trained |= {f"{key}.training.seeds[{index}]": seed for index, seed in seeds}
        if (own := study.evaluation) is not None:
            # Trained variants are candidates for a selection; other policies are only reported.
            blocks = chosen if study.training and len(study.run) > 1 else both
            drawn[f"{key}.evaluation"] = own.seed, own.trials, blocks
    for key, seed in trained.items():
        require(seed not in final, key, f"none of seeds.final ({final})", seed)
    for key, (first, trials, blocks) in drawn.items():
        last, expected = first + trials - 1, f"seeds within {' or '.join(map(str, blocks))}"
        possible = any(first in block and last in block for block in blocks)
        require(possible, f"{key}.seed", expected, f"{first} to {last}")
