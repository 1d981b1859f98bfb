"""The layout of a policy: the plain data that a robot's own software needs beside the network.

Units: SI and radians. x forward, y left, z up. Positive joint angles are right-handed turns about
the axes in the robot model; a slide grows as the leg gets longer.
"""

from typing import Any

import numpy as np

from slider.config.convert import to_dict
from slider.config.env import EstimatorConfig
from slider.control import REFERENCE
from slider.control.policy import Policy
from slider.env.estimator import Leg
from slider.env.interface import AgentInterface
from slider.env.observations import TERMS, VELOCITY_ERROR_RANGE
from slider.library.lookup import GaitTable, StepTimes
from slider.robot.names import (
    ACTUATED,
    MIRROR_PERMUTATION,
    NUM_JOINTS,
    SIDES,
    VELOCITY,
    channel_units,
    joint_names,
    motor_names,
)
from slider.robot.transmission import Transmission, by_motor

FORMAT = "slider-policy-layout"
VERSION = 10
INPUT, OUTPUT = "observations", "actions"
OLDEST_MUJOCO = "3.12"  # that reads robot.xml: its motors are DC motors; 3.8 refuses them

_PROCEDURE = [
    "start: clock.phase = 0, previous action = 0, filtered, reference and expected velocity = 0, "
    "heading target = yaw; the clock is halted, if it halts at a command of zeros and this is one",
    "every control_period, from the second step on: advance the clock, the heading target, the "
    "reference velocity, then the velocity filters with the present state and the command of the "
    "period that is over",
    "mirrored = clock.mirror and phase >= 0.5 (right stance); never without a clock",
    "o = concatenation of the observation's terms, each value times its scale",
    "if mirrored: o = o[observation.mirror.permutation] * observation.mirror.sign",
    "o = clip(o, -observation.clip, observation.clip), as float32; a = network(o)",
    "a = clip(a, -action.clip, action.clip)",
    "if mirrored: a = a[action.mirror.permutation] * action.mirror.sign",
    "a[i] = 0 where action.joints[i].scale is 0; a is the next step's previous action",
    "target[i] = clip(reference[i] + scale[i] * a[i], lower[i], upper[i]), held for one control "
    "period by the motors: motor[m] goes to angle sum of joints[name] * target[name], with torque "
    "kp * (angle - own angle) - kd * own speed, at most torque_limit in size and within the line "
    "from stall_torque at rest to 0 at no_load_speed",
]


def describe(
    policy: Policy, provenance: dict[str, Any], estimator: EstimatorConfig | None = None
) -> dict[str, Any]:
    """Layout of a policy as nested plain values, ready for JSON.

    ``provenance`` is copied unchanged; ``estimator`` is that of the state on board.
    """
    env, network = policy.env, policy.network
    agent = AgentInterface(policy.robot, env, 1, policy.times, policy.reference)
    observer = agent.observer
    gain = env.observation.filter_gain(env.control_period)
    return {
        "format": FORMAT,
        "version": VERSION,
        "robot": policy.robot.name,
        "control_period": env.control_period,
        "procedure": _PROCEDURE,
        "network": {
            "input": INPUT,
            "output": OUTPUT,
            "type": "float32",
            "hidden": list(policy.hidden),
            "activation": policy.activation,
            "normaliser": {
                "inside_network": True,
                "formula": "(o - mean) / std",
                "mean": network.mean.tolist(),
                "std": network.std.tolist(),
            },
        },
        "observation": {
            "size": observer.size,
            "clip": env.observation.clip,
            "terms": _terms(policy, agent),
            "mirror": {
                "permutation": observer.permutation.tolist(),
                "sign": observer.sign.tolist(),
            },
            "nominal_height": agent.nominal_height,
            "velocity_filter": {"time_constant": env.observation.velocity_filter, "gain": gain},
            "velocity_error": {"range": VELOCITY_ERROR_RANGE},
            "height_scan": to_dict(env.observation.height_scan),
        },
        "action": {
            "size": NUM_JOINTS,
            "offset": env.action.offset,
            "clip": env.action.clip,
            "joints": _joints(policy, agent),
            "motors": _motors(policy),
            "mirror": {
                "permutation": list(MIRROR_PERMUTATION),
                "sign": agent.mirror_sign.tolist(),
            },
        },
        "clock": _clock(policy),
        "reference": _reference(policy),
        "estimator": None if estimator is None else _estimator(policy, estimator),
        "simulation": {
            "timestep": env.physics.timestep,
            "substeps": env.physics.substeps,
            "mujoco": OLDEST_MUJOCO,
        },
        "training": dict(policy.facts),
        "provenance": provenance,
    }


def _terms(policy: Policy, agent: AgentInterface) -> list[dict[str, Any]]:
    start, rows = 0, []
    for name, width in agent.observer.layout.items():
        scale = policy.env.observation.terms[name]
        place = {"name": name, "start": start, "width": width, "scale": scale}
        rows.append(place | TERMS[name].describe(width, policy.robot.geometry))
        start += width
    return rows


def reference_table(policy: Policy) -> GaitTable:
    """Joint positions of a zero action: those of the gaits, or the nominal pose."""
    if policy.reference is not None:
        return policy.reference
    nominal = AgentInterface(policy.robot, policy.env, 1, policy.times).nominal
    return GaitTable(StepTimes.constant(1.0), np.tile(nominal, (1, 1, 1, 4, 1)))


def _reference(policy: Policy) -> dict[str, Any]:
    """Joint positions of a zero action, by reference velocity and phase."""
    table = reference_table(policy)
    return {
        "file": REFERENCE,
        "axes": [*VELOCITY, "sample", "joint"],
        "acceleration": policy.env.reference.acceleration,
        "shape": list(table.values.shape),
        **_axes(table.times),
        "standing": table.standing.tolist(),
        "meaning": "joint positions of a zero action at the reference velocity, the commanded yaw "
        "rate and the clock's phase (0 without one): linear along vx, vy and yaw_rate, the nearest "
        "border's outside; the first "
        "half of the samples is left stance, the second right stance, evenly spaced over the step "
        "with both of its ends, linear in between; standing: while the clock is halted. The "
        "reference "
        "velocity is 0 at the start; each control step but the first, vx and vy go towards those "
        "of the command of the period that is over, by at most acceleration * control_period; an "
        "acceleration of 0: it is the present command",
    }


def _axes(times: StepTimes) -> dict[str, list[float]]:
    return {name: axis.tolist() for name, axis in zip(VELOCITY, times, strict=True)}


def _joints(policy: Policy, agent: AgentInterface) -> list[dict[str, Any]]:
    geometry = policy.robot.geometry
    names, kinds = joint_names(geometry), geometry.leg_joints * len(SIDES)
    units, (lower, upper) = channel_units(geometry), policy.robot.joint_ranges
    return [
        {
            "name": name,
            "unit": units[index],
            "actuated": index in ACTUATED,
            "nominal": float(agent.nominal[index]),
            "scale": policy.env.action.scale[kind],
            "lower": float(lower[index]),
            "upper": float(upper[index]),
        }
        for index, (name, kind) in enumerate(zip(names, kinds, strict=True))
    ]


def _motors(policy: Policy) -> list[dict[str, Any]]:
    """Motors; the greatest torque falls linearly with speed from the stall torque to 0."""
    motors, geometry = Transmission.of(policy.robot), policy.robot.geometry
    joints, names = joint_names(geometry), motor_names(geometry)
    gains = by_motor(policy.robot, policy.robot.gains) * len(SIDES)
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


def _estimator(policy: Policy, config: EstimatorConfig) -> dict[str, Any] | None:
    """Settings of the estimator on board, and masses that the force of a foot follows from.

    ``run_policy.py`` has it for legs that slide.
    """
    if policy.robot.geometry.knee is not None:
        return None
    return {
        "meaning": "a Kalman filter of the base's velocity and height, from inertial unit, "
        "encoders and motor torques: see Estimator in run_policy.py",
        **to_dict(config),
        **Leg.of(policy.robot)._asdict(),
    }


def _clock(policy: Policy) -> dict[str, Any] | None:
    """The clock's pace: trilinear in the reference command, the border's value outside."""
    if not policy.env.phase.enabled or policy.times is None:
        return None
    return {
        "mirror": policy.env.phase.mirror,
        "halt": {"below": policy.env.phase.halt.below, "above": policy.env.phase.halt.above},
        "halting": "where halt.below is above 0: at a command of zeros, with the filtered velocity "
        "(of the step before) less than halt.below in size and the velocity itself less than "
        "halt.above, the phase does not pass the next change of feet (0 or 0.5); there the clock "
        "is halted until there is a command, or the velocity itself reaches halt.above",
        "advance": "phase = (phase + control_period / (2 * step_time(reference velocity, commanded "
        "yaw rate))) modulo 1, before the reference velocity moves; "
        "left stance below 0.5, right stance from there on; step_time[i][j][k] is at vx[i], vy[j], "
        "yaw_rate[k], linear along each in between, the nearest border's outside",
        **_axes(policy.times),
        "step_time": policy.times.step_time.tolist(),
    }
