"""Small inputs made by hand: a gait library, robot states, views and the configurations."""

import re
from dataclasses import replace
from functools import cache
from typing import Any

import mujoco
import numpy as np
import yaml
from omegaconf import OmegaConf

from slider.config.convert import from_dict, to_dict, with_settings
from slider.config.env import DisturbanceConfig, EnvConfig, HeightScan, OnboardConfig, PhysicsConfig
from slider.config.robot import RobotConfig
from slider.config.schema import Config
from slider.core.arrays import tensors
from slider.env.disturbance import Disturbance
from slider.env.guide import Guide
from slider.env.instruments import CONTACT_FORCE, Contacts
from slider.env.interface import FLOAT64, AgentInterface
from slider.env.physics import BatchedPhysics
from slider.env.rollout import Recording
from slider.env.state import RobotState, View
from slider.library.lookup import GaitTable
from slider.library.reader import GaitLibrary
from slider.robot.mjcf import Actuation, nominal_qpos
from slider.robot.names import (
    MIRROR_PERMUTATION,
    NUM_JOINTS,
    channels,
    joint_names,
    mirror_sign,
    motor_names,
)
from slider.robot.transmission import Transmission
from tests.config.composed import composed

PERMUTATION = np.array(MIRROR_PERMUTATION)
SAMPLES = 42
STEP_TIME = 0.4
TURNING = (-0.3, 0.0, 0.3)  # yaw rates of a library that turns [rad/s]


@cache
def config(*overrides: str) -> Config:
    """Composed by Hydra, which takes half a second, but for values of ``env`` alone."""
    own = [text for text in overrides if re.match(r"env\.(?!sensing)", text)]
    whole = composed(*(text for text in overrides if text not in own))
    changes = dict(text.removeprefix("env.").split("=", 1) for text in own)
    changes = {name: yaml.safe_load(value) for name, value in changes.items()}
    return replace(whole, env=from_dict(EnvConfig, with_settings(to_dict(whole.env), changes)))


def robot_config() -> RobotConfig:
    return config("experiment=test").robot


GEOMETRY = robot_config().geometry
JOINTS, MOTORS, CHANNELS = joint_names(GEOMETRY), motor_names(GEOMETRY), channels(GEOMETRY)
SIGN = np.array(mirror_sign(GEOMETRY))
TRANSMISSION = Transmission.of(robot_config())
VELOCITIES = ((0.0, 0.0), (0.4, 0.0), (0.0, 0.1), (0.4, 0.1))


@cache
def library(*yaw_rates: float) -> GaitLibrary:
    """Gaits that step in place with small sinusoids, the second step a mirror of the first.

    Amplitude and step time grow with vx, so that gaits differ; those that turn yaw their hips.
    """
    grid = np.array([(*velocity, rate) for velocity in VELOCITIES for rate in yaw_rates or (0.0,)])
    samples, base = map(np.stack, zip(*(_gait(*command) for command in grid), strict=True))
    times = np.tile(step_time(grid[:, :1]), 2)
    arrays = {"velocities": grid, "samples": samples, "base": base, "step_time": times}
    return GaitLibrary(arrays, {})


@cache
def gait_table(*yaw_rates: float) -> GaitTable:
    return GaitTable.from_library(library(*yaw_rates))


def step_time(vx: Any) -> Any:
    return STEP_TIME - 0.1 * vx


def _gait(vx: float, vy: float, yaw_rate: float) -> tuple[np.ndarray, np.ndarray]:
    duration = 2 * step_time(vx)
    per_step = SAMPLES // 2
    first = 0.5 * np.arange(per_step) / (per_step - 1)
    phase = np.concatenate([first, 0.5 + first])
    joints, rates = np.zeros((SAMPLES, NUM_JOINTS)), np.zeros((SAMPLES, NUM_JOINTS))
    swing = 0.1 + 0.2 * vx
    for leg, offset in enumerate((0.0, 0.5)):
        angle, speed = 2 * np.pi * (phase + offset), 2 * np.pi / duration
        for name, amplitude in (("hip_pitch", swing), ("ankle", -swing), ("hip_roll", 0.02)):
            column = JOINTS.index(f"left_{name}") + 6 * leg
            sign = -1.0 if name == "hip_roll" and leg else 1.0
            joints[:, column] = sign * amplitude * np.sin(angle)
            rates[:, column] = sign * amplitude * speed * np.cos(angle)
        column = JOINTS.index("left_slide") + 6 * leg
        joints[:, column] = -0.02 * (1 - np.cos(angle))
        rates[:, column] = -0.02 * speed * np.sin(angle)
    ramp = yaw_rate * duration / 2 * (0.5 - np.tile(2 * first, 2)) * np.repeat([1, -1], per_step)
    joints[:, JOINTS.index("left_hip_yaw")] = ramp
    joints[:, JOINTS.index("right_hip_yaw")] = -ramp
    samples = np.concatenate([joints, rates, np.tile([vx, vy], (SAMPLES, 1))], axis=1)
    base = np.zeros((SAMPLES, 13))
    base[:, 0], base[:, 1] = vx * duration * phase, vy * duration * phase
    base[:, 2] = nominal_qpos(robot_config())[2]
    course = yaw_rate * duration / 2 * (2 * phase - 0.5)
    base[:, 3], base[:, 6] = np.cos(course / 2), np.sin(course / 2)
    base[:, 7], base[:, 8] = vx, vy
    return samples, base


def make_guide(gait: str = "interpolated", *yaw_rates: float) -> Guide:
    geometry = robot_config().geometry
    return Guide(library(*yaw_rates), gait_table(*yaw_rates), geometry, gait)


def make_physics(count: int, **settings: float) -> BatchedPhysics:
    physics: PhysicsConfig = replace(config("experiment=test").env.physics, **settings)
    return BatchedPhysics(robot_config(), physics, count)


@cache
def disturbance(*settings: str) -> DisturbanceConfig:
    """That of the test's evaluation with settings such as ``mass={lower: 0.9, upper: 1.1}``."""
    values = to_dict(config("experiment=test").evaluation.disturbance)
    merged = OmegaConf.merge(values, OmegaConf.from_dotlist([*settings]))
    return from_dict(DisturbanceConfig, OmegaConf.to_container(merged))


def disturbed_physics(
    count: int,
    *settings: str,
    actuation: Actuation = "position",
    substeps: int = 4,
    seeds: tuple[int, ...] = (1,),
    onboard: OnboardConfig | None = None,
) -> BatchedPhysics:
    """Physics with disturbances; ``settings`` as for :func:`disturbance`."""
    physics = replace(config("experiment=test").env.physics, substeps=substeps)
    drawn = Disturbance(disturbance(*settings), seeds)
    return BatchedPhysics(robot_config(), physics, count, 1, actuation, drawn, onboard=onboard)


def stand(physics: BatchedPhysics, seconds: float = 0.0) -> BatchedPhysics:
    """Put the robots upright and at rest in the nominal pose, and let them hold it."""
    count = physics.num_robots
    qpos = np.tile(nominal_qpos(robot_config()), (count, 1))
    physics.reset(np.arange(count), qpos, np.zeros((count, 18)))
    for _ in range(round(seconds / physics.period)):
        physics.step(np.zeros((count, NUM_JOINTS)))
    return physics


def momentum(physics: BatchedPhysics) -> np.ndarray:
    """Of each robot (N, 3) [kg m/s]."""
    data = mujoco.MjData(physics.model)
    result = []
    for qpos, qvel, mass in zip(physics.qpos, physics.qvel, physics.masses, strict=True):
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(physics.model, data)
        mujoco.mj_subtreeVel(physics.model, data)
        result.append(mass * data.subtree_linvel[1])
    return np.array(result)


def make_agent(count: int, *overrides: str) -> AgentInterface:
    """The agent of an environment; ``overrides`` are Hydra's."""
    settings = config("experiment=test", *overrides)
    table = gait_table()
    return AgentInterface(settings.robot, settings.env, count, table.times, table.joints)


def random_pose(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions (count, 19) and velocities (count, 18), tilted, turned and moving."""
    quaternion = np.array([1.0, 0.0, 0.0, 0.0]) + 0.3 * rng.standard_normal((count, 4))
    quaternion /= np.linalg.norm(quaternion, axis=1, keepdims=True)
    position = rng.uniform(-0.2, 0.2, (count, 3)) + [0.0, 0.0, 0.9]
    joints = 0.1 * rng.standard_normal((count, NUM_JOINTS))
    qvel = 0.5 * rng.standard_normal((count, 6 + NUM_JOINTS))
    return np.concatenate([position, quaternion, joints], axis=1), qvel


def mirror_pose(qpos: np.ndarray, qvel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same robots seen in a mirror at the world's x-z plane."""
    positions, velocities = qpos.copy(), qvel.copy()
    positions[:, [1, 4, 6]] *= -1.0  # y, rotation about x and z
    positions[:, 7:] = qpos[:, 7:][:, PERMUTATION] * SIGN
    velocities[:, [1, 3, 5]] *= -1.0
    velocities[:, 6:] = qvel[:, 6:][:, PERMUTATION] * SIGN
    return positions, velocities


def make_state(count: int, **changes: np.ndarray | list | float) -> RobotState:
    """Robots at rest in the nominal pose, as tensors, with ``changes`` of some quantities."""
    return make_arrays(count, **changes).tensors(FLOAT64)


def make_arrays(count: int, **changes: np.ndarray | list | float) -> RobotState:
    """The same as NumPy's arrays."""
    height = float(nominal_qpos(robot_config())[2])
    state = RobotState(
        base_position=np.tile([0.0, 0.0, height], (count, 1)),
        quaternion=np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
        rotation=np.tile(np.eye(3), (count, 1, 1)),
        yaw=np.zeros(count),
        linear_velocity=np.zeros((count, 3)),
        angular_velocity=np.zeros((count, 3)),
        heading_velocity=np.zeros((count, 2)),
        gravity=np.tile([0.0, 0.0, -1.0], (count, 1)),
        joint_positions=np.zeros((count, NUM_JOINTS)),
        joint_velocities=np.zeros((count, NUM_JOINTS)),
        motor_torques=np.zeros((count, len(MOTORS))),
        foot_positions=np.zeros((count, 2, 3)),
        foot_velocities=np.zeros((count, 2, 3)),
        foot_forces=np.zeros((count, 2)),
        body_contacts=np.zeros(count),
        diverged=np.zeros(count, dtype=bool),
    )
    for name, value in changes.items():
        whole = getattr(state, name)
        whole[...] = np.asarray(value, dtype=whole.dtype)
    return state


def make_contacts(forces: np.ndarray, **changes: np.ndarray) -> Contacts:
    """Feet flat on the ground that do not slide, of legs 0.1 m apart, by forces (T, N, 2) [N]."""
    ends = (*forces.shape, 2)
    contacts = Contacts(
        forces=forces,
        loaded=np.broadcast_to((forces > CONTACT_FORCE)[..., None], ends),
        speeds=np.zeros(ends),
        depths=np.zeros(forces.shape),
        leg_distance=np.full(forces.shape[:2], 0.1),
    )
    return contacts._replace(**changes)


def make_recording(command: np.ndarray, **changes: Any) -> Recording:
    """Robots that stay up, at rest, by their commands (T, N, 3) in control steps of 20 ms.

    ``foot_forces`` (T, N, 2), or 50 N, hold for the four simulation steps of a control step.
    """
    steps, count = command.shape[:2]
    forces = changes.pop("foot_forces", np.full((steps, count, 2), 50.0))
    still = Recording(
        period=0.02,
        command=command,
        alive=np.ones((steps, count), dtype=bool),
        velocity=np.zeros((steps, count, 2)),
        yaw=np.zeros((steps, count)),
        position=np.zeros((steps, count, 2)),
        foot_positions=np.zeros((steps, count, 2, 3)),
        contacts=make_contacts(np.repeat(forces, 4, axis=0)),
        estimate_error=np.zeros((steps, count, 4)),
        power=np.zeros((steps, count)),
        effort_share=np.zeros((steps, count)),
        speed_share=np.zeros((steps, count)),
        diverged=np.zeros(count, dtype=bool),
        weight=np.full(count, 100.0),
    )
    return replace(still, **changes)


def make_view(state: RobotState, **changes: np.ndarray) -> View:
    """A view of a state with zero commands and actions, with ``changes``."""
    count = state.num_robots
    values = {
        "command": np.zeros((count, 4)),
        "action": np.zeros((count, NUM_JOINTS)),
        "previous_action": np.zeros((count, NUM_JOINTS)),
        "action_scale": np.full(NUM_JOINTS, 0.3),
        "filtered_velocity": np.zeros((count, 2)),
        "phase": np.zeros(count),
    }
    values |= {name: np.array(value, dtype=float, order="C") for name, value in changes.items()}
    for name in ("reference_velocity", "expected_velocity"):  # those of a command long since given
        values.setdefault(name, values["command"][:, :2])
    values["halted"] = np.array(changes.get("halted", np.zeros(count)), dtype=bool, order="C")
    view = View(
        state=state,
        nominal=np.zeros(NUM_JOINTS),
        nominal_height=float(nominal_qpos(robot_config())[2]),
        torque_limits=TRANSMISSION.torque,
        period=0.02,
        scan=HeightScan(15, 12, 0.1),
        **values,
    )
    return tensors(view, FLOAT64)


def random_view(count: int, mirrored: bool = False) -> View:
    """A view of robots in random motion, or of the same robots in a mirror.

    Quantities of sensors, which are 0 before the first step, are random, too.
    """
    rng = np.random.default_rng(7)
    pose = random_pose(rng, count)
    command = rng.uniform(-0.2, 0.6, (count, 4))
    actions = rng.standard_normal((2, count, NUM_JOINTS))
    filtered, expected = rng.standard_normal((2, count, 2))
    phase = rng.uniform(size=count)
    torques = rng.standard_normal((count, 2, len(MOTORS) // 2))
    positions, velocities = rng.standard_normal((2, count, 2, 3))
    forces, contacts = rng.uniform(10.0, 200.0, (count, 2)), rng.uniform(0.0, 3.0, count)
    if mirrored:
        pose, phase = mirror_pose(*pose), (phase + 0.5) % 1.0
        command = command * [1.0, -1.0, -1.0, -1.0]
        actions = actions[..., PERMUTATION] * SIGN
        filtered, expected = filtered * [1.0, -1.0], expected * [1.0, -1.0]
        torques = torques[:, ::-1] * [-1.0, -1.0, 1.0, 1.0, 1.0]  # yaw and roll flip
        positions, velocities = (v[:, ::-1] * [1.0, -1.0, 1.0] for v in (positions, velocities))
        forces = forces[:, ::-1].copy()
    physics = make_physics(count)
    physics.reset(np.arange(count), *pose)
    state = replace(
        physics.read(),
        motor_torques=torques.reshape(count, -1),
        foot_positions=positions,
        foot_velocities=velocities,
        foot_forces=forces,
        body_contacts=contacts,
    )
    return make_view(
        state,
        command=command,
        action=actions[0],
        previous_action=actions[1],
        filtered_velocity=filtered,
        expected_velocity=expected,
        phase=phase,
    )
