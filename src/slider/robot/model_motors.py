"""Limits, gains and speeds of the motors in a model file."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import re
from collections.abc import Iterator, Mapping
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np

_BEND, _TIME = 0.5, 0.025  # position loop: error at the torque limit [rad]; kd / kp [s]
_KNEE_AND_ANKLE = {"speed": 15.0, "stall_ratio": 2.0, "inertia": 0.0}  # no such motors in SLIDER
GUESS = f"kp = torque / {_BEND} rad, kd = kp × {_TIME} s, 15 rad/s, ratio 2, no rotor"


def urdf_speeds(content: bytes) -> dict[str, float]:
    """Velocity limits [rad/s, m/s] by joint of a URDF, which MuJoCo does not read."""
    text = re.sub(rb"(?s)<!DOCTYPE.*?>", b"", content)
    try:
        limits = {
            joint.get("name", ""): float(limit.get("velocity") or 0.0)
            for joint in ElementTree.fromstring(text).iter("joint")
            for limit in joint.iter("limit")
        }
    except (ElementTree.ParseError, ValueError):
        return {}
    return {name: speed for name, speed in limits.items() if 0.0 < speed < np.inf}


def motor_of(
    model: mujoco.MjModel, joint: int, speeds: Mapping[str, float]
) -> dict[str, tuple[float, str]]:
    """Torque, speed, inertia, kp and kd of a joint's motor in a model, each with its source.

    The gains of several actuators are added; the smallest torque limit is used.
    """
    found = {}
    acts = [
        act
        for act in range(model.nu)
        if model.actuator_trntype[act] == mujoco.mjtTrn.mjTRN_JOINT
        and model.actuator_trnid[act, 0] == joint
    ]
    limits = [limit for limit in _limits(model, joint, acts) if 0.0 < limit[0] < np.inf]
    if limits:
        found["torque"] = min(limits)
    affine = [k for k in acts if model.actuator_biastype[k] == mujoco.mjtBias.mjBIAS_AFFINE]
    squares = model.actuator_gear[affine, 0] ** 2
    kp, kd = (float(-squares @ model.actuator_biasprm[affine, k]) for k in (1, 2))
    damping = model.dof_damping[model.jnt_dofadr[joint]]
    if kp > 0.0:
        found["kp"] = kp, "kp"
        found |= {"kd": (max(kd, 0.0), "kv")} if kd > 0.0 or damping > 0.0 else {}
    if model.dof_armature[model.jnt_dofadr[joint]] > 0.0:
        found["inertia"] = 0.0, "armature"
    name = model.joint(joint).name
    return found | ({"speed": (speeds[name], "velocity")} if name in speeds else {})


def _limits(model: mujoco.MjModel, joint: int, acts: list[int]) -> Iterator[tuple[float, str]]:
    if model.jnt_actfrclimited[joint]:
        yield float(np.abs(model.jnt_actfrcrange[joint]).max()), "actuatorfrcrange or effort"
    for act in acts:
        gear = abs(float(model.actuator_gear[act, 0]))
        plain = model.actuator_gaintype[act] == mujoco.mjtGain.mjGAIN_FIXED
        plain = plain and model.actuator_biastype[act] == mujoco.mjtBias.mjBIAS_NONE
        if model.actuator_forcelimited[act]:
            yield gear * float(np.abs(model.actuator_forcerange[act]).max()), "forcerange"
        if plain and model.actuator_ctrllimited[act]:
            most = np.abs(model.actuator_ctrlrange[act]).max() * abs(model.actuator_gainprm[act, 0])
            yield gear * float(most), "ctrlrange"


def drives(
    motors: Mapping[str, Mapping[str, tuple[float, str]]], typed: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, str]]:
    """``drives`` and ``gains`` of ``conf/robot`` by motor, and the source of each by dotted key.

    Gains that neither the model nor the robot file has are guessed if torque limits are known.
    """
    values: dict[str, Any] = {"drives": {}, "gains": {}}
    sources = {}
    for name, motor in motors.items():
        own = {f"{'gains' if k[0] == 'k' else 'drives'}.{name}.{k}": v for k, v in motor.items()}
        kp, kd, torque = f"gains.{name}.kp", f"gains.{name}.kd", f"drives.{name}.torque"
        limit = typed.get(torque, own.get(torque, (None,))[0])
        if isinstance(limit, int | float):
            own.setdefault(kp, (limit / _BEND, "rule"))
            for quantity, value in _KNEE_AND_ANKLE.items():
                if name in ("slide", "ankle", "ankle_roll"):
                    own.setdefault(f"drives.{name}.{quantity}", (value, "rule"))
        loop = typed.get(kp, own.get(kp, (None,))[0])
        if isinstance(loop, int | float):
            own.setdefault(kd, (loop * _TIME, "rule"))
        for key, (value, source) in own.items():
            if key not in typed:
                group, _, quantity = key.split(".")
                values[group].setdefault(name, {})[quantity] = float(f"{value:.9g}")
                sources[key] = source
    return values, sources
