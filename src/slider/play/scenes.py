"""What ``slider play`` can show: a policy, another controller, a smoke agent or a gait."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TypeVar

from slider.config.control import POLICY, SMOKE_AGENTS, HzdControlConfig
from slider.config.env import EnvConfig, PlantConfig
from slider.config.hzd import enforced_section
from slider.config.robot import RobotConfig
from slider.config.schema import Config
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.policy import load_policy
from slider.core.errors import UserError
from slider.library.reader import GaitLibrary
from slider.play.motion import Motion, Replay, simulate_agent, simulate_model_based, simulate_policy

Section = TypeVar("Section", EnvConfig, RobotConfig)


@dataclass(frozen=True)
class Scene:
    """A motion, the robot that moves, and the highest forward command [m/s]."""

    title: str
    robot: RobotConfig
    motion: Motion
    top: float


def policy_scene(path: Path, config: Config, plain: Config, seed: int) -> Scene:
    """A policy on its own robot and in its own environment.

    Args:
        path: of the policy file.
        config: its parts of robot and environment that differ from ``plain`` replace the policy's.
        plain: the same configuration without overrides.
        seed: of start and disturbance.

    Raises:
        UserError: the policy is for other observations or actions.
    """
    policy = load_policy(path)
    robot = _changed(policy.robot, config.robot, plain.robot)
    env = _changed(policy.env, config.env, plain.env)
    test = config.evaluation
    motion = simulate_policy(policy, robot, env, test.start, seed, test.disturbance)
    return Scene(f"policy {path}", robot, motion, config.speeds.top)


def _changed(own: Section, asked: Section, plain: Section) -> Section:
    """What a policy was trained with, but for the parts that the overrides change."""
    names = [item.name for item in fields(own)]
    parts = {name: getattr(asked, name) for name in names}
    return replace(own, **{n: part for n, part in parts.items() if part != getattr(plain, n)})


def agent_scene(
    name: str, config: Config, gaits: Callable[[], tuple[Path, Path]], seed: int
) -> Scene:
    """A controller of the configuration as in its evaluation, or a smoke agent.

    ``gaits`` finds library and foot placement for those that walk by them.

    Raises:
        UserError: there is no agent of this name.
    """
    test, env = config.evaluation, config.env
    if name in config.control:
        plant = PlantConfig(env.control_period, env.physics, env.termination)
        control, disturbance = config.control[name], test.disturbance
        enforced = None
        if isinstance(control, HzdControlConfig):
            enforced = EnforcedGaits.load(*gaits(), enforced_section(config.hzd))
        motion = simulate_model_based(
            config.robot, plant, control, enforced, test.start, seed, disturbance
        )
        return Scene(f"controller {name}", config.robot, motion, config.speeds.top)
    if name in SMOKE_AGENTS:
        motion = simulate_agent(config.robot, env, test.start, seed, random=name == "random")
        return Scene(f"agent {name}", config.robot, motion, config.speeds.top)
    known = ", ".join((POLICY, *config.control, *SMOKE_AGENTS))
    raise UserError(f"agent: expected one of {known}, found {name}")


def gait_scene(path: Path, command: Sequence[float], config: Config) -> Scene:
    """The gait of a library that is nearest to vx, vy [m/s], yaw rate [rad/s]; no physics."""
    motion = Replay(GaitLibrary.load(path), command, config.env.control_period)
    vx, vy, yaw_rate = motion.command
    turn = f" {yaw_rate:+.2f} rad/s" if yaw_rate else ""
    return Scene(f"gait {vx:.2f} {vy:+.2f} m/s{turn}", config.robot, motion, config.speeds.top)
