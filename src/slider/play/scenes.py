"""What ``slider play`` can show: a policy, another controller, a smoke agent or a gait.

Policies, controllers and agents move a simulated robot; a gait is replayed without physics.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import torch

from slider.config.control import POLICY, SMOKE_AGENTS, HzdControlConfig
from slider.config.env import EnvConfig
from slider.config.hzd import enforced_section
from slider.config.robot import Mechanism, RobotConfig
from slider.config.schema import Config
from slider.control.exported import load_exported
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.model_based import build_controller, build_plant
from slider.control.policy import PolicyController, agent_of, load_policy
from slider.core.errors import one_of, require
from slider.env.disturbance import Disturbance
from slider.env.interface import AgentInterface
from slider.env.physics import BatchedPhysics
from slider.env.rollout import Episode, Frame
from slider.env.starts import multiply_quaternions
from slider.library.lookup import StepTimes
from slider.library.mesh import distances
from slider.library.reader import GaitLibrary
from slider.robot.kinematics import about_z
from slider.robot.names import NUM_JOINTS

Section = TypeVar("Section", EnvConfig, RobotConfig)
_STEP_TIME = 0.4  # of the phase that smoke agents observe [s]


@dataclass(frozen=True)
class Scene:
    """A motion, the robot that moves, and the highest commanded speed [m/s]."""

    title: str
    robot: RobotConfig
    motion: "Motion"
    top: float


def policy_scene(path: Path, config: Config, plain: Config, seed: int) -> Scene:
    """A policy file on its own robot and in its own environment, or the folder of an export.

    Parts of both in which ``config`` differs from ``plain``, which has no overrides, replace the
    policy's. An export runs on the robot and in the environment of ``config``.

    Raises:
        UserError: the policy is for other observations or actions, or for another robot.
    """
    if path.is_dir():
        robot, env = config.robot, config.env
        controller = load_exported(path, robot, env)
    else:
        policy = load_policy(path)
        robot = _changed(policy.robot, config.robot, plain.robot)
        env = _changed(policy.env, config.env, plain.env)
        env = replace(env, onboard=config.env.onboard)  # none if trained on the true state
        controller = PolicyController(policy.network, agent_of(policy, robot, env, 1))
    disturbance = Disturbance(config.evaluation.disturbance, (seed,))
    physics = BatchedPhysics(
        robot, env.physics, 1, 1, disturbance=disturbance, onboard=env.estimation
    )
    motion = Episode(controller, physics, env, config.evaluation.start, seed)
    return Scene(f"policy {path}", robot, motion, config.speeds.top)


def _changed(own: Section, asked: Section, plain: Section) -> Section:
    """Configuration of a policy's training, except the parts that overrides change."""
    names = [item.name for item in fields(own)]
    changed = [name for name in names if getattr(asked, name) != getattr(plain, name)]
    return replace(own, **{name: getattr(asked, name) for name in changed})


def agent_scene(
    name: str, config: Config, gaits: Callable[[], tuple[Path, Path]], seed: int
) -> Scene:
    """A controller of ``conf/control`` on torque drives, as in its evaluation, or a smoke agent.

    ``gaits`` returns library and foot placement for controllers that need them. For a policy see
    :func:`policy_scene`.

    Raises:
        UserError: there is no agent of this name.
    """
    one_of("agent", name, (POLICY, *config.control, *SMOKE_AGENTS))
    robot, env = config.robot, config.env
    if name in SMOKE_AGENTS:  # they hold the nominal pose, or their actions are uniform in ±1
        env = replace(env, action=replace(env.action, offset="nominal"))
        generator, size = torch.Generator().manual_seed(seed), float(name == "random")
        controller = PolicyController(
            lambda _: size * (2.0 * torch.rand(1, NUM_JOINTS, generator=generator) - 1.0),
            AgentInterface(robot, env, 1, StepTimes.constant(_STEP_TIME)),
        )
        physics = BatchedPhysics(robot, env.physics, 1, 1)
    else:
        env, control, enforced = env.plant, config.control[name], None
        if isinstance(control, HzdControlConfig):
            enforced = EnforcedGaits.load(*gaits(), enforced_section(config.hzd))
        disturbance = Disturbance(config.evaluation.disturbance, (seed,))
        physics = build_plant(robot, env, control, 1, disturbance)
        controller = build_controller(robot, control, env.physics, 1, enforced)
    motion = Episode(controller, physics, env, config.evaluation.start, seed)
    kind = "agent" if name in SMOKE_AGENTS else "controller"
    return Scene(f"{kind} {name}", robot, motion, config.speeds.top)


def gait_scene(path: Path, velocity: Sequence[float], config: Config) -> Scene:
    """The gait of a library that is nearest to vx, vy [m/s], yaw rate [rad/s]; no physics.

    Raises:
        UserError: the library is of another robot.
    """
    library = GaitLibrary.load(path)
    own = [getattr(library.robot, part.name) for part in fields(Mechanism)]
    same = own == [getattr(config.robot, part.name) for part in fields(Mechanism)]
    expected = f"gaits of the robot {config.robot.name} (another: --set robot=...)"
    require(same, str(path), expected, "those of another robot")
    motion = Replay(library, velocity, config.env.control_period)
    vx, vy, yaw_rate = motion.velocity
    turn = f" {yaw_rate:+.2f} rad/s" if yaw_rate else ""
    return Scene(f"gait {vx:.2f} {vy:+.2f} m/s{turn}", config.robot, motion, config.speeds.top)


class Replay:
    """Replays the gait nearest to a velocity (3,) repeatedly, moving along its course."""

    terrain = None

    def __init__(self, library: GaitLibrary, velocity: Sequence[float], period: float) -> None:
        index = int(distances(library.velocities, velocity).argmin())
        self.period, self.velocity = period, library.velocities[index]
        names = ("step_time", "base", "samples")
        durations, base, samples = (library.arrays[name][index] for name in names)
        self._duration = float(durations.sum())
        half = len(samples) // 2
        first, second = (np.linspace(0.0, duration, half) for duration in durations)
        self._times = np.concatenate([first, durations[0] + second])
        self._qpos = np.concatenate([base[:, :7], samples[:, :NUM_JOINTS]], axis=1)
        self._steps = 0

    def start(self, velocity: np.ndarray) -> Frame:
        """Begin with left stance; the gait keeps its own velocity."""
        self._steps = 0
        return self._frame()

    def step(self, velocity: np.ndarray) -> Frame:
        """Return the next frame."""
        self._steps += 1
        return self._frame()

    def push(self, change: np.ndarray) -> None:
        """Ignore it: a replay has no physics to push."""

    def _frame(self) -> Frame:
        time = self._steps * self.period
        walks, since = divmod(time, self._duration)
        qpos = np.array([np.interp(since, self._times, column) for column in self._qpos.T])
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
        if self.velocity[2]:
            self._turn(qpos, int(walks))
        else:
            qpos[:2] += walks * self._duration * self.velocity[:2]
        return Frame(time, qpos, self.velocity[:2], failed=False)

    def _turn(self, qpos: np.ndarray, walks: int) -> None:
        """Advance a pose (19,) in place by a number of turning walks."""
        angle = self.velocity[2] * self._duration
        axes = about_z(np.array([angle]))[0, :2, :2]
        walk = self._qpos[-1, :2] - axes @ self._qpos[0, :2]  # of the stance foot
        for _ in range(walks):
            qpos[:2] = walk + axes @ qpos[:2]
        turn = np.array([[np.cos(walks * angle / 2), 0.0, 0.0, np.sin(walks * angle / 2)]])
        qpos[3:7] = multiply_quaternions(turn, qpos[None, 3:7])[0]


Motion = Episode | Replay
"""Frames at a fixed period [s] of a robot that is commanded to a velocity (3,)."""
