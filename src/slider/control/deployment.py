"""A step of a policy, and of the onboard estimator, as functions of what a robot measures.

Both use the classes of training and evaluation. Their memory between calls is a state, one row of
numbers per robot; a state of zeros restarts them. A value that is NaN, or beyond ``LARGEST``, is
replaced by the last valid one; so is a quaternion that is not of unit length.
"""

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any, NamedTuple

import torch

from slider.config.env import EnvConfig, EstimatorConfig
from slider.config.robot import RobotConfig
from slider.control.onnx_graph import Function
from slider.control.policy import Policy
from slider.core.errors import UserError
from slider.env.estimator import StateEstimator
from slider.env.interface import FLOAT64, AgentInterface
from slider.robot.kinematics import rotation_from_quaternion, turn_to_heading, yaw_of
from slider.robot.mjcf import nominal_qpos
from slider.robot.names import NUM_JOINTS, VELOCITY, motor_names

LARGEST = 1e6  # of a reading
_ALL = slice(None)  # robots
_AGENT = {
    "command": 4,
    "action": NUM_JOINTS,
    "previous_action": NUM_JOINTS,
    "filtered_velocity": 2,
    "reference_velocity": 2,
    "expected_velocity": 2,
    "heading_target": 1,
}
_CLOCK = {"phase": 1, "halted": 1}
_ESTIMATOR = {"velocity": 3, "position": 3, "bias": 3, "variance": 2, "rates": 2, "forces": 2}

Tensors = dict[str, torch.Tensor]


class Reading(NamedTuple):
    """An input: unit, meaning and the values (width,) that it has before the first valid one."""

    unit: str
    meaning: str
    default: list[float]


class Step(NamedTuple):
    """A function: readings (N, width) and a state (N, size) → outputs and the next state."""

    function: Function
    readings: dict[str, Reading]
    outputs: tuple[str, ...]
    state_size: int


def readings(robot: RobotConfig, env: EnvConfig) -> dict[str, Reading]:
    """Inputs of a policy that has every observation."""
    scan, height, *_ = env.observation.height_scan, float(nominal_qpos(robot)[2])
    grid = scan.points_x * scan.points_y
    return {
        **_measured(robot),
        "linear_velocity": Reading(
            "m/s", "velocity of the base's origin, in the base frame", [0.0] * 3
        ),
        "height": Reading("m", "of the base's origin above the ground under the feet", [height]),
        "height_scan": Reading(
            "m",
            "height of the base's origin above points around it: see height_scan; from back to "
            "front, in each row from right to left",
            [height] * grid,
        ),
        "command": Reading(
            "m/s, m/s, rad/s", f"{', '.join(VELOCITY)}: forward, leftward, turning left", [0.0] * 3
        ),
    }


def _measured(robot: RobotConfig) -> dict[str, Reading]:
    """Readings of IMU and encoders."""
    nominal = nominal_qpos(robot)[7:].tolist()
    return {
        "quaternion": Reading("-", "attitude, base to world: w, x, y, z", [1.0, 0.0, 0.0, 0.0]),
        "angular_velocity": Reading("rad/s", "of the base, in the base frame", [0.0] * 3),
        "joint_positions": Reading("rad or m", "in the order of joints", nominal),
        "joint_velocities": Reading("rad/s or m/s", "in the order of joints", [0.0] * NUM_JOINTS),
    }


def policy_step(policy: Policy) -> Step:
    """A control step of a policy: readings → joint targets (N, 12) [rad or m].

    Raises:
        UserError: an observation needs a quantity that is not an input.
    """
    needs = {"height": "base_height", "height_scan": "height_scan"}
    given = {
        name: reading
        for name, reading in readings(policy.robot, policy.env).items()
        if needs.get(name, name) in policy.observations or name not in needs
    }

    def agent(memory: Tensors) -> AgentInterface:
        made = AgentInterface(policy.robot, policy.env, 1, policy.times, policy.reference)
        for name, value in memory.items():
            value = value.clone()
            value = value[:, 0] if name in ("heading_target", "phase", "halted") else value
            if name in _AGENT:
                setattr(made, name, value)
            elif made.clock is not None:
                setattr(made.clock, name, value > 0 if name == "halted" else value)
        return made

    def step(fresh: torch.Tensor, now: Tensors, memory: Tensors) -> tuple[Tensors, Tensors]:
        state, velocity = _state(now), now["command"]
        begun = agent({name: torch.zeros_like(value) for name, value in memory.items()})
        begun.set_velocity_command(_ALL, velocity)
        begun.reset(_ALL, state)
        begun.refresh_heading(state)
        moved = agent(memory)
        moved.advance(state)
        moved.set_velocity_command(_ALL, velocity)
        either = zip(_stored(begun).values(), _stored(moved).values(), strict=True)
        memory = {
            name: first.where(fresh, later)
            for name, (first, later) in zip(memory, either, strict=True)
        }
        acting = agent(memory)
        try:
            observations = acting.observe(state)
        except AttributeError as error:
            expected = f"expected observations of {', '.join(given)}"
            found = f"found one that needs {error.name}"
            raise UserError(f"policy export: {expected}, {found}") from None
        targets = acting.act(policy.network(observations))
        return {"joint_targets": targets}, _stored(acting)

    memory = _AGENT | (_CLOCK if agent({}).clock else {})
    return _with_state(step, given, memory, ("joint_targets",))


def _stored(agent: AgentInterface) -> Tensors:
    values = {name: getattr(agent, name) for name in _AGENT}
    if agent.clock is not None:
        values |= {name: getattr(agent.clock, name) for name in _CLOCK}
    columns = {name: value.reshape(len(value), -1) for name, value in values.items()}
    return {name: value.to(FLOAT64) for name, value in columns.items()}


def _state(now: Tensors) -> Any:
    """The quantities of a robot that observations read."""
    rotation = rotation_from_quaternion(now["quaternion"])
    yaw = yaw_of(rotation)
    state = SimpleNamespace(
        rotation=rotation, yaw=yaw, gravity=-rotation[:, 2], ground=None, scanned=None
    )
    for name in ("angular_velocity", "joint_positions", "joint_velocities"):
        setattr(state, name, now[name])
    if "linear_velocity" in now:
        state.linear_velocity = now["linear_velocity"]
        velocity = torch.einsum("nij,nj->ni", rotation, state.linear_velocity)
        state.heading_velocity = turn_to_heading(velocity, yaw)
    if "height" in now:
        state.base_height = now["height"][:, 0]
    if "height_scan" in now:
        state.base_position = torch.zeros_like(now["angular_velocity"])
        below = -now["height_scan"]
        state.scanned = SimpleNamespace(flat=False, height=lambda points: below)
    return state


def estimator_step(robot: RobotConfig, config: EstimatorConfig) -> Step:
    """A step of the estimator: readings → velocity (N, 3) [m/s] and height (N, 1) [m]."""
    given = {
        **_measured(robot),
        "motor_torques": Reading(
            "N m",
            "mean since the last reading, in the order of motors; over the same interval as "
            "velocity_increment",
            [0.0] * len(motor_names(robot.geometry)),
        ),
        "velocity_increment": Reading(
            "m/s",
            "integral of the specific force since the last reading, in the base frame: at rest "
            "gravity times elapsed, upwards",
            [0.0] * 3,
        ),
        "elapsed": Reading("s", "since the last reading; ignored at the first", [0.0]),
    }

    def step(fresh: torch.Tensor, now: Tensors, memory: Tensors) -> tuple[Tensors, Tensors]:
        estimator = StateEstimator(config, robot, 1, FLOAT64)
        for name, value in memory.items():
            setattr(estimator, name, value)
        estimator.fresh = fresh[:, 0]
        elapsed = now["elapsed"][:, 0].where(~estimator.fresh, 0.0)
        state = _state(now)
        state.motor_torques = now["motor_torques"]
        estimate = estimator.update(state, now["velocity_increment"], elapsed)
        outputs = {
            "linear_velocity": torch.einsum("nji,nj->ni", state.rotation, estimate.velocity),
            "height": estimate.position[:, 2:],
        }
        return outputs, {name: getattr(estimator, name) for name in _ESTIMATOR}

    return _with_state(step, given, _ESTIMATOR, ("linear_velocity", "height"))


def _with_state(
    step: Callable[[torch.Tensor, Tensors, Tensors], tuple[Tensors, Tensors]],
    given: dict[str, Reading],
    memory: Mapping[str, int],
    outputs: tuple[str, ...],
) -> Step:
    """Pack a step's memory and the last readings into one state array; see the module."""
    sizes = [1, *memory.values(), *(len(reading.default) for reading in given.values())]

    def function(*values: torch.Tensor) -> list[torch.Tensor]:
        *new, state = values
        parts, start = [], 0
        for size in sizes:
            parts.append(state[:, start : start + size])
            start += size
        fresh, kept, before = parts[0] == 0, parts[1 : 1 + len(memory)], parts[1 + len(memory) :]
        now = {}
        for (name, reading), value, last in zip(given.items(), new, before, strict=True):
            good = value.abs() < LARGEST  # false for NaN
            if name == "quaternion":
                good = ((value * value).sum(1, keepdim=True) - 1.0).abs() < 0.1
            default = value.new_tensor(reading.default)
            now[name] = value.where(good, default.where(fresh, last))
        results, kept = step(fresh, now, dict(zip(memory, kept, strict=True)))
        following = [torch.ones_like(parts[0]), *kept.values(), *now.values()]
        return [*results.values(), torch.cat(following, dim=1)]

    return Step(function, given, outputs, sum(sizes))
