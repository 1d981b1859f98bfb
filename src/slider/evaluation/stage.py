"""The stages ``evaluation`` and ``baseline``: the same protocol for every controller.

It fixes plant, starts, velocities, terminations, disturbances and records.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from slider.config.control import FAMILIES
from slider.config.convert import from_dict
from slider.config.env import EnvConfig, PlantConfig, StartNoise
from slider.config.evaluation import CaseConfig, EvaluationConfig
from slider.config.robot import RobotConfig
from slider.control import POLICY_FILE
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.model_based import build_controller, build_plant
from slider.control.policy import PolicyController, agent_of, load_policy
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.disturbance import Disturbance
from slider.env.metrics import estimate_error, gait_quality, tracking
from slider.env.physics import BatchedPhysics
from slider.env.rollout import Controller, Recording, roll_out
from slider.env.starts import at_rest
from slider.evaluation import results, segments
from slider.evaluation.results import Evaluation
from slider.evaluation.segments import profile_of


@dataclass(frozen=True)
class Protocol:
    """One controller at one command or in one case of a profile: all trials and robots.

    Attributes:
        controller: name of the controller, a row of the table.
        speed: commanded forward velocity [m/s]; None in a case.
        case: its changing commands; None at a constant one.
        robot: the plant's robot.
        config: trials, starts and what is measured.
    """

    controller: str
    speed: float | None
    case: CaseConfig | None
    robot: RobotConfig
    config: EvaluationConfig

    @property
    def count(self) -> int:
        """Number of robots of all trials."""
        return self.config.trials * self.config.robots

    @property
    def seeds(self) -> range:
        """Trial k draws from seed + k, whatever the controller or command."""
        return range(self.config.seed, self.config.seed + self.config.trials)

    @property
    def disturbance(self) -> Disturbance:
        """Those of all trials."""
        return Disturbance(self.config.disturbance, tuple(self.seeds))


@dataclass(frozen=True)
class Simulated:
    """N robots in physics with their controller, and the control period and terminations."""

    controller: Controller
    physics: BatchedPhysics
    env: EnvConfig | PlantConfig


def read_protocol(section: Section) -> Protocol:
    """The protocol of a stage's section.

    Raises:
        UserError: a value is missing or has another type.
    """
    speed, case = section["speed"], section.get("case")
    return Protocol(
        controller=section["controller"],
        speed=None if speed is None else float(speed),
        case=None if case is None else from_dict(CaseConfig, case),
        robot=from_dict(RobotConfig, section["robot"]),
        config=from_dict(EvaluationConfig, section["evaluation"]),
    )


def evaluate(protocol: Protocol, simulated: Simulated, out: Path, job: Job) -> Summary:
    """Roll a controller out and write per-robot records and mean velocity traces.

    In a case of a profile also the records and traces of its segments.
    """
    config, case = protocol.config, protocol.case
    speeds = [protocol.speed or 0.0]
    start, command = at_speeds(protocol.robot, config.start, protocol.seeds, config.robots, speeds)
    if case is not None:
        ramp, period = profile_of(config).ramp, simulated.env.control_period
        values = segments.velocities(case, ramp, config.duration, period)
        command = np.repeat(values[:, None], protocol.count, axis=1)
    recording = roll_out(
        simulated.controller,
        simulated.physics,
        simulated.env,
        start,
        command,
        config.duration,
        lambda share: job.progress(f"{100 * share:.0f} %"),
    )
    tracked = tracking(
        recording, config.warm_up, config.tracking_tolerance, config.tracking_relative
    )
    quality = gait_quality(recording, config.warm_up)
    errors = estimate_error(recording, config.warm_up)
    robots = results.robots(
        config.trials, config.robots, tracked, quality, errors, recording.diverged
    )
    evaluation = Evaluation(protocol.controller, protocol.speed, robots, _traces(recording))
    if case is not None:
        evaluation = replace(
            evaluation,
            case=case.name,
            segments=tuple(segments.measure(recording, config, case)),
            traces=segments.traces(recording, config),
        )
    evaluation.save(out)
    return _summary(evaluation)


def at_speeds(
    robot: RobotConfig,
    noise: StartNoise,
    seeds: Iterable[int],
    robots: int,
    speeds: Sequence[float],
) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Starts (N, 19), (N, 18) and commanded velocities (N, 3) of constant speeds [m/s].

    In blocks of a seed, and in these of a speed with ``robots`` each: all speeds start alike.
    """
    draws = [at_rest(robot, noise, np.random.default_rng(seed), robots) for seed in seeds]
    qpos, qvel = zip(*(start for start in draws for _ in speeds), strict=True)
    velocities = np.zeros((len(qpos) * robots, 3))
    velocities[:, 0] = np.tile(np.repeat(speeds, robots), len(draws))
    return (np.concatenate(qpos), np.concatenate(qvel)), velocities


def _traces(recording: Recording) -> np.ndarray:
    """Mean and standard deviation over surviving robots of the forward velocity (S, 2) [m/s]."""
    forward = recording.velocity[:, recording.survived, 0]
    if forward.shape[1] == 0:
        return np.full((len(forward), 2), np.nan, dtype=np.float32)
    return np.stack([forward.mean(axis=1), forward.std(axis=1)], axis=1).astype(np.float32)


def _summary(evaluation: Evaluation) -> dict[str, Any]:
    robots = evaluation.robots
    case = {"case": evaluation.case} if evaluation.case else {}
    return {
        "controller": evaluation.controller,
        "speed": evaluation.speed,
        **case,
        "success_rate": robots.success.value,
        "mse_steady": robots.mse_steady.value if robots.survived.any() else None,
        "blow_ups": int(robots.columns["diverged"].sum()),
    }


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll the policy out on position drives, once per control period."""
    torch.set_num_threads(job.threads)
    protocol = read_protocol(section)
    simulated = simulate(section, inputs, protocol.count, protocol.disturbance, job.threads)
    return evaluate(protocol, simulated, out, job)


def run_baseline(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll a controller of ``conf/control`` out on torque drives, at its own, higher rate.

    Its nominal model is that of the section's robot, from which the disturbed plants differ.
    """
    protocol = read_protocol(section)
    disturbance, threads = protocol.disturbance, job.threads
    simulated = simulate_baseline(section, inputs, protocol.count, disturbance, threads)
    return evaluate(protocol, simulated, out, job)


def simulate(
    section: Section,
    inputs: Inputs,
    count: int,
    disturbance: Disturbance,
    threads: int = 1,
) -> Simulated:
    """The policy of the walking stage on ``count`` robots.

    A study may evaluate it on another robot than its training's. Plant, starts and drives are then
    those of the changed robot; the policy keeps nominal pose, ranges of joint targets, scales,
    reference gaits and clock of its training.

    Raises:
        UserError: the policy is for other observations or actions.
    """
    robot, env = from_dict(RobotConfig, section["robot"]), from_dict(EnvConfig, section["env"])
    policy = load_policy(inputs["walking"][0] / POLICY_FILE)
    physics = BatchedPhysics(
        robot, env.physics, count, threads, disturbance=disturbance, onboard=env.estimation
    )
    agent = agent_of(policy, policy.robot, env, count)
    return Simulated(PolicyController(policy.network, agent), physics, env)


def simulate_baseline(
    section: Section, inputs: Inputs, count: int, disturbance: Disturbance, threads: int = 1
) -> Simulated:
    """A controller of ``conf/control`` on ``count`` robots."""
    robot = from_dict(RobotConfig, section["robot"])
    plant = from_dict(PlantConfig, section["plant"])
    config = from_dict(FAMILIES[section["control"]["family"]], section["control"])
    physics = build_plant(robot, plant, config, count, disturbance, threads)
    gaits = EnforcedGaits.of(section, inputs)
    controller = build_controller(robot, config, plant.physics, count, gaits, threads)
    return Simulated(controller, physics, plant)
