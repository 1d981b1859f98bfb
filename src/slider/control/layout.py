"""The contract of an exported policy: all that a robot's own software needs besides the graphs.

Units: SI and radians. x forward, y left, z up. Positive joint angles are right-handed turns about
the axes in the robot model; the position of a slide increases as the leg extends.
"""

from typing import Any

import numpy as np

from slider.config.convert import to_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.control import MODEL
from slider.control.deployment import Step
from slider.control.onnx_graph import OPSET
from slider.control.policy import Policy
from slider.env.observations import TERMS
from slider.robot.mjcf import nominal_qpos
from slider.robot.names import (
    SIDES,
    VELOCITY,
    channel_units,
    driven_joints,
    joint_names,
    motor_names,
)
from slider.robot.transmission import Transmission, by_motor

FORMAT = "slider-policy-layout"
VERSION = 11
STATE, NEXT_STATE = "state", "next_state"
OLDEST_MUJOCO = "3.12"  # that reads robot.xml: its motors are DC motors; 3.8 refuses them

_PROCEDURE = [
    "start: state = zeros (1, state_size); the robot stands in the default joint positions",
    "every control_period: call the graph with the inputs, each (1, size), and the state; apply "
    "the joint targets; keep next_state for the next call. All are float64",
    "after a stop, a restart or a delay of several periods: reset the state to zeros",
    "targets are held for one control period by the motors: motor m tracks angle = sum of "
    "joints[name] * target[name], with torque kp * (angle - own angle) - kd * own speed, at most "
    "torque_limit in size and within the line from stall_torque at rest to 0 at no_load_speed",
    "an input that is not a number is replaced by the one before it",
]


def describe(policy: Policy, provenance: dict[str, Any], graphs: dict[str, Step]) -> dict[str, Any]:
    """Contract of a policy as nested plain values, ready for JSON.

    ``provenance`` is copied unchanged; ``graphs`` are the steps by the names of their files.
    """
    env, geometry = policy.env, policy.robot.geometry
    scale = [env.action.scale[kind] for kind in geometry.leg_joints * len(SIDES)]
    times = policy.times
    return {
        "format": FORMAT,
        "version": VERSION,
        **hardware(policy.robot, env),
        "procedure": _PROCEDURE,
        "graphs": {name: _graph(step) for name, step in graphs.items()},
        "opset": OPSET,
        "simulation": {
            "file": MODEL,
            "timestep": env.physics.timestep,
            "mujoco": OLDEST_MUJOCO,
            "base_height": float(nominal_qpos(policy.robot)[2]),
            "actuators": "are named like the motors; their control is the motor's angle",
        },
        "network": {"hidden": list(policy.hidden), "activation": policy.activation},
        "observation": _terms(policy),
        "action": {"scale": scale, "clip": env.action.clip, "offset": env.action.offset},
        "clock": None
        if times is None
        else {
            "step_time": [float(np.min(times.step_time)), float(np.max(times.step_time))],
            "mirror": env.phase.mirror,
        },
        "training": dict(policy.training),
        "provenance": provenance,
    }


def hardware(robot: RobotConfig, env: EnvConfig) -> dict[str, Any]:
    """Properties that robot and environment of an exported policy must have."""
    return {
        "robot": robot.name,
        "control_period": env.control_period,
        "joints": _joints(robot),
        "motors": _motors(robot),
        "height_scan": to_dict(env.observation.height_scan),
    }


def metadata(layout: dict[str, Any], step: Step) -> dict[str, str]:
    """Metadata of an ONNX file: keys and comma-separated lists as in mjlab, and a few more."""

    def joined(values: Any) -> str:
        return ",".join(str(value) for value in values)

    def column(name: str) -> str:
        return joined(joint[name] for joint in layout["joints"])

    return {
        "joint_names": column("name"),
        "joint_stiffness": column("stiffness"),
        "joint_damping": column("damping"),
        "default_joint_pos": column("default"),
        "action_scale": joined(layout["action"]["scale"]),
        "observation_names": joined(name for name in step.readings if name != "command"),
        "command_names": joined(VELOCITY),
        "control_period": str(layout["control_period"]),
        "quaternion_order": "w,x,y,z",
        "opset": str(OPSET),
    }


def _graph(step: Step) -> dict[str, Any]:
    inputs = {
        name: {"size": len(reading.default), "unit": reading.unit, "meaning": reading.meaning}
        for name, reading in step.readings.items()
    }
    state = {"input": STATE, "output": NEXT_STATE, "size": step.state_size}
    return {"inputs": inputs, "outputs": list(step.outputs), "state": state}


def _terms(policy: Policy) -> list[dict[str, Any]]:
    start, rows = 0, []
    for name, width in policy.observations.items():
        scale = policy.env.observation.terms[name]
        place = {"name": name, "start": start, "width": width, "scale": scale}
        rows.append(place | TERMS[name].describe(width, policy.robot.geometry))
        start += width
    return rows


def _joints(robot: RobotConfig) -> list[dict[str, Any]]:
    """Joints; stiffness and damping are sums over their motors."""
    motors, geometry = Transmission.of(robot).matrix, robot.geometry
    gains = by_motor(robot, robot.gains) * len(SIDES)
    units, (lower, upper) = channel_units(geometry), robot.joint_ranges
    nominal = nominal_qpos(robot)[7:]
    stiffness, damping = (
        [getattr(gain, name) for gain in gains] @ motors**2 for name in ("kp", "kd")
    )
    return [
        {
            "name": name,
            "unit": units[index],
            "actuated": index in driven_joints(geometry),
            "default": float(nominal[index]),
            "lower": float(lower[index]),
            "upper": float(upper[index]),
            "stiffness": float(stiffness[index]),
            "damping": float(damping[index]),
        }
        for index, name in enumerate(joint_names(geometry))
    ]


def _motors(robot: RobotConfig) -> list[dict[str, Any]]:
    """Motors; the available torque falls linearly with speed from the stall torque to 0."""
    motors, geometry = Transmission.of(robot), robot.geometry
    joints, names = joint_names(geometry), motor_names(geometry)
    gains = by_motor(robot, robot.gains) * len(SIDES)
    return [
        {
            "name": name,
            "joints": {joints[j]: float(row[j]) for j in np.flatnonzero(row)},
            "kp": gains[index].kp,
            "kd": gains[index].kd,
            "torque_limit": float(motors.torque[index]),
            "stall_torque": float(motors.stall[index]),
            "no_load_speed": float(motors.speed[index]),
            "rotor_inertia": float(motors.inertia[index]),
        }
        for index, (name, row) in enumerate(zip(names, motors.matrix, strict=True))
    ]
