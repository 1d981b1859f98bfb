"""The stages ``evaluation`` and ``baseline``: the same protocol for every controller.

It fixes plant, starts, velocities, terminations, disturbances and records.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from slider.config.control import FAMILIES
from slider.config.convert import from_dict
from slider.config.env import DisturbanceConfig, EnvConfig, PlantConfig
from slider.config.evaluation import CaseConfig, EvaluationConfig, GaugeProtocol
from slider.config.robot import RobotConfig
from slider.control import POLICY_FILE
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.model_based import build_controller, build_plant
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.disturbance import Disturbance
from slider.env.metrics import estimate_error, gait_quality, tracking
from slider.env.physics import BatchedPhysics
from slider.env.rollout import Controller, Recording, roll_out
from slider.env.starts import at_rest
from slider.evaluation import results, segments
from slider.evaluation.results import Evaluation

Engine = Callable[..., BatchedPhysics]
"""Creates the robots' physics from the arguments of ``BatchedPhysics``."""


class Setup(NamedTuple):
    """A controller, its N robots in physics, and the control period and terminations."""

    controller: Controller
    physics: BatchedPhysics
    env: EnvConfig | PlantConfig


def run(
    section: Section, inputs: Inputs, out: Path, job: Job, engine: Engine = BatchedPhysics
) -> Summary:
    """Roll a controller out and write per-robot records and mean velocity traces.

    All trials and robots of one ``case``; with a profile also the records and traces of its
    segments are written.
    """
    config = from_dict(EvaluationConfig, section["evaluation"])
    case, profile = from_dict(CaseConfig, section["case"]), config.profile
    recording = record(
        section,
        inputs,
        config,
        [case],
        job.threads,
        build=partial(set_up, engine=engine),
        ramp=profile.ramp if profile else 0.0,
        progress=lambda share: job.progress(f"{100 * share:.0f} %"),
    )
    limits = config.warm_up, config.tracking_tolerance, config.tracking_relative
    metrics = tracking(recording, *limits) | gait_quality(recording, config.warm_up)
    metrics |= estimate_error(recording, config.warm_up) | {"diverged": recording.diverged}
    robots = results.robots_frame(config.trials, config.robots, metrics)
    forward = recording.velocity[:, recording.survived, 0]
    velocity = np.full((len(forward), 2), np.nan, dtype=np.float32)
    if forward.shape[1]:
        velocity[:, 0], velocity[:, 1] = forward.mean(axis=1), forward.std(axis=1)
    speed = None if profile else case.segments[0].vx
    evaluation = Evaluation(section["controller"], speed, robots, velocity)
    if profile:
        evaluation = replace(
            evaluation,
            case=case.name,
            segments=segments.measure(recording, config, case),
            traces=segments.traces(recording, config),
        )
    evaluation.save(out)
    rates = results.success(robots) | results.accuracy(robots)
    return {
        "controller": evaluation.controller,
        "speed": speed,
        **({"case": case.name} if profile else {}),
        **{name: rates[name] for name in ("success_rate", "tracking_rate")},
        "mse_steady": rates["mse_steady"] if robots["survived"].any() else None,
        "diverged": int(recording.diverged.sum()),
    }


def seeds_of(config: EvaluationConfig | GaugeProtocol) -> range:
    """Trial k draws from seed + k, whatever the controller or command."""
    return range(config.seed, config.seed + config.trials)


def set_up(
    section: Section,
    inputs: Inputs,
    count: int,
    disturbance: Disturbance,
    threads: int = 1,
    engine: Engine = BatchedPhysics,
) -> Setup:
    """A controller of ``conf/control``, or the policy of the walking stage, on ``count`` robots.

    A controller of ``conf/control`` commands torques at its own rate; its internal model is the
    nominal robot, from which the disturbed plants differ. A policy commands joint positions once
    per control period. A study may evaluate it on another robot than its training's: plant,
    starts and drives are those of the changed robot; the policy keeps nominal pose, ranges of joint
    targets, scales, reference gaits and clock of its training.

    Raises:
        UserError: the policy is for other observations or actions.
    """
    robot = from_dict(RobotConfig, section["robot"])
    if "control" in section:
        plant = from_dict(PlantConfig, section["plant"])
        config = from_dict(FAMILIES[section["control"]["family"]], section["control"])
        physics = build_plant(robot, plant, config, count, disturbance, threads, engine)
        gaits = None
        if "foot_placement" in inputs:
            folders = inputs["library"][0], inputs["foot_placement"][0]
            gaits = EnforcedGaits.load(*folders, section["hzd"])
        controller = build_controller(robot, config, plant.physics, count, gaits, threads)
        return Setup(controller, physics, plant)
    import torch  # other controllers do not need the 2 s that this takes

    from slider.control.policy import PolicyController, agent_of, load_policy

    torch.set_num_threads(threads)
    env = from_dict(EnvConfig, section["env"])
    policy = load_policy(inputs["walking"][0] / POLICY_FILE)
    agent = agent_of(policy, policy.robot, env, count)
    physics = engine(
        robot, env.physics, count, threads, disturbance=disturbance, onboard=env.estimation
    )
    return Setup(PolicyController(policy.network, agent), physics, env)


def record(
    section: Section,
    inputs: Inputs,
    protocol: EvaluationConfig | GaugeProtocol,
    cases: Sequence[CaseConfig],
    threads: int,
    disturbance: DisturbanceConfig | None = None,
    build: Callable[..., Setup] = set_up,
    ramp: float = 0.0,
    progress: Callable[[float], None] = lambda share: None,
) -> Recording:
    """Roll a controller out in all cases at once, with a ``disturbance`` or the protocol's.

    Robots are ordered by seed, then by case; within a seed all cases have the same initial states.
    ``build`` takes the arguments of :func:`set_up`; a command changes within ``ramp`` seconds.
    """
    robot, seeds = from_dict(RobotConfig, section["robot"]), seeds_of(protocol)
    starts = (
        at_rest(robot, protocol.start, np.random.default_rng(seed), protocol.robots)
        for seed in seeds
    )
    qpos, qvel = map(np.concatenate, zip(*(s for s in starts for _ in cases), strict=True))
    disturbed = Disturbance(disturbance or protocol.disturbance, tuple(seeds))
    setup = build(section, inputs, len(qpos), disturbed, threads)
    timing = ramp, protocol.duration, setup.env.control_period
    series = np.stack([segments.velocities(case, *timing) for case in cases], axis=1)
    velocities = np.tile(np.repeat(series, protocol.robots, axis=1), (1, len(seeds), 1))
    return roll_out(*setup, (qpos, qvel), velocities, protocol.duration, progress)
