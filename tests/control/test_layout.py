"""The contract says everything, and says it right."""

import json
from dataclasses import replace

import numpy as np
import pytest

from slider.control import ESTIMATOR, ONNX
from slider.control.deployment import estimator_step, policy_step
from slider.control.layout import describe, metadata
from slider.env.observations import TERMS
from tests.control.policies import make_policy
from tests.env.synthetic import JOINTS, MOTORS, TRANSMISSION, config

SETTINGS = config("experiment=test").env.estimator


def contract(policy) -> dict:
    graphs = {ONNX: policy_step(policy), ESTIMATOR: estimator_step(policy.robot, SETTINGS)}
    return describe(policy, {}, graphs)


@pytest.mark.parametrize("name", ["default", "paper", "all"])
def test_terms_tile_the_observation_and_are_explained(name):
    policy = make_policy("env=paper" if name == "paper" else "env=default")
    if name == "all":
        terms = dict.fromkeys(TERMS, 1.0)
        observation = replace(policy.env.observation, terms=terms)
        env = replace(policy.env, observation=observation)
        sizes = {"height_scan": 180}
        policy = replace(policy, env=env, observations=policy.observations | sizes)
    layout = contract(policy)
    assert json.loads(json.dumps(layout)) == layout
    assert (layout["clock"] is None) == (name == "paper")
    inputs = layout["graphs"][ONNX]["inputs"]
    assert ("height" in inputs, "height_scan" in inputs) == (name != "paper", name != "default")
    end = 0
    assert [row["name"] for row in layout["observation"]] == [*policy.observations]
    for row in layout["observation"]:
        assert row["start"] == end
        assert row["meaning"]
        assert len(row["units"]) == row["width"], row["name"]
        assert len(row["components"]) == row["width"] or row["name"] == "height_scan"
        end += row["width"]


def test_gains_limits_and_scales_are_the_robots():
    layout = contract(make_policy("robot.gains.capstan.kp=2.2", "env.action.scale.slide=0.07"))
    joints, motors = ({row["name"]: row for row in layout[part]} for part in ("joints", "motors"))
    assert (tuple(joints), tuple(motors)) == (JOINTS, MOTORS)
    slide, foot = joints["right_slide"], joints["left_upper_foot"]
    assert slide["unit"] == "m"
    assert (slide["lower"], slide["upper"]) == (-0.4, 0.4)
    assert (foot["actuated"], foot["stiffness"]) == (False, 0.0)
    scale = dict(zip(joints, layout["action"]["scale"], strict=True))
    assert (scale["right_slide"], scale["left_upper_foot"]) == (0.07, 0.0)
    values = ("kp", "kd", "torque_limit", "stall_torque", "no_load_speed", "rotor_inertia")
    found = [motors["right_leg_2"][name] for name in values]
    assert found == [2.2, 0.047, 9.0, 18.0, 120.0, 6.25e-4]


def test_metadata_has_the_keys_that_mjlab_writes():
    policy = make_policy()
    layout, motors = contract(policy), contract(policy)["motors"]
    found = metadata(layout, policy_step(policy))
    lists = {name: value.split(",") for name, value in found.items()}
    assert tuple(lists["joint_names"]) == JOINTS
    for name in ("joint_stiffness", "joint_damping", "default_joint_pos", "action_scale"):
        assert len([float(value) for value in lists[name]]) == len(JOINTS), name
    # Both motors of a leg, each by its share, twice: as a lever and as the way that it turns.
    shares = [motor["joints"].get("left_slide", 0.0) for motor in motors]
    stiffness = sum(motor["kp"] * share**2 for motor, share in zip(motors, shares, strict=True))
    assert float(lists["joint_stiffness"][JOINTS.index("left_slide")]) == pytest.approx(stiffness)
    assert lists["command_names"] == ["vx", "vy", "yaw_rate"]
    assert lists["observation_names"][0] == "quaternion"
    assert (found["control_period"], found["opset"]) == ("0.02", "13")
    assert found["quaternion_order"] == "w,x,y,z"


def test_the_motors_take_targets_to_the_angles_that_the_procedure_says():
    targets = np.random.default_rng(2).uniform(-0.3, 0.3, 12)
    named = dict(zip(JOINTS, targets, strict=True))
    angles = [
        sum(share * named[joint] for joint, share in motor["joints"].items())
        for motor in contract(make_policy())["motors"]
    ]
    np.testing.assert_allclose(angles, TRANSMISSION.angles(targets), rtol=1e-12)
