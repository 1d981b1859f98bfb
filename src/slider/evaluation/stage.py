"""The stage ``evaluation``: one controller at one command, all trials and robots."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import torch

from slider.control.policy import PolicyController
from slider.control.policy_file import load_policy
from slider.core.config.convert import from_dict
from slider.core.config.env import EnvConfig
from slider.core.config.evaluation import EvaluationConfig
from slider.core.config.robot import RobotConfig
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.interface import AgentInterface
from slider.env.metrics import gait_quality, tracking
from slider.env.physics import BatchedPhysics
from slider.env.rollout import Controller, Recording, roll_out
from slider.env.starts import at_rest
from slider.evaluation import records

VELOCITIES = "velocity.npy"


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll a controller out and write per-robot records and mean velocity traces."""
    torch.set_num_threads(job.threads)
    robot = from_dict(RobotConfig, section["robot"])
    env = from_dict(EnvConfig, section["env"])
    config = from_dict(EvaluationConfig, section["evaluation"])
    command = float(section["command"])
    controller = build_controller(section["controller"], inputs, robot, env, _count(config))
    recording = _simulate(controller, robot, env, config, command, job)
    tracked = tracking(
        recording, config.steady_from, config.tracking_tolerance, config.tracking_relative
    )
    quality = gait_quality(recording, config.steady_from)
    table = records.build(config.trials, config.robots, tracked, quality, recording.diverged)
    records.write(table, out / records.FILE)
    np.save(out / VELOCITIES, _traces(recording))
    (out / "command.json").write_text(
        json.dumps({"controller": section["controller"], "command": command}) + "\n"
    )
    summary = _summary(section["controller"], command, table)
    job.tracker.log_metrics({k: v for k, v in summary.items() if isinstance(v, float)}, 0)
    return summary


def _count(config: EvaluationConfig) -> int:
    return config.trials * config.robots


def build_controller(
    name: str, inputs: Inputs, robot: RobotConfig, env: EnvConfig, count: int
) -> Controller:
    """Controller of a name for ``count`` robots.

    Raises:
        UserError: there is none of this name, or the policy is for other observations.
    """
    if name != "policy":
        raise UserError(f"evaluation.controllers: expected policy, found {name}")
    policy = load_policy(inputs["walking"][0] / "policy.pt")
    agent = AgentInterface(robot, env, count, policy.times)
    if list(agent.observer.layout.items()) != list(policy.observations.items()):  # order counts
        raise UserError(
            f"policy: expected the observations {agent.observer.layout}, "
            f"found {policy.observations}"
        )
    return PolicyController(policy.network, agent)


def _simulate(
    controller: Controller,
    robot: RobotConfig,
    env: EnvConfig,
    config: EvaluationConfig,
    command: float,
    job: Job,
) -> Recording:
    physics = BatchedPhysics(robot, env.physics, _count(config), job.threads)
    velocity = np.zeros((_count(config), 3))
    velocity[:, 0] = command
    return roll_out(
        controller,
        physics,
        env,
        _starts(robot, config),
        velocity,
        config.duration,
        lambda share: job.progress(f"{100 * share:.0f} %"),
    )


def _starts(robot: RobotConfig, config: EvaluationConfig) -> tuple[np.ndarray, np.ndarray]:
    """Starts of all robots; trial k draws from seed + k, whatever the controller or command."""
    starts = [
        at_rest(robot, config.start, np.random.default_rng(config.seed + trial), config.robots)
        for trial in range(config.trials)
    ]
    return np.concatenate([s[0] for s in starts]), np.concatenate([s[1] for s in starts])


def _traces(recording: Recording) -> np.ndarray:
    """Mean and standard deviation over surviving robots of the forward velocity (S, 2) [m/s]."""
    forward = recording.velocity[:, recording.survived, 0]
    if forward.shape[1] == 0:
        return np.full((len(forward), 2), np.nan, dtype=np.float32)
    return np.stack([forward.mean(axis=1), forward.std(axis=1)], axis=1).astype(np.float32)


def _summary(controller: str, command: float, table: records.Records) -> dict[str, Any]:
    survivors = table["survived"]
    steady = table["squared_error_steady"][survivors]
    return {
        "controller": controller,
        "command": command,
        "success_rate": float(survivors.mean()),
        "mse_steady": float(steady.mean()) if survivors.any() else None,
        "blow_ups": int(table["diverged"].sum()),
    }
