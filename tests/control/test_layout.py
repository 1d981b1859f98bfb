"""The layout says everything, and says it right."""

import json
from dataclasses import replace

import numpy as np
import pytest

from slider.config.env import EstimatorConfig
from slider.control.layout import describe, reference_table
from slider.env.observations import TERMS
from tests.control.policies import make_policy
from tests.env.synthetic import JOINTS, MOTORS, gait_table, motor_angles
from tests.robot.lopsided import kneed


@pytest.mark.parametrize("name", ["default", "paper", "all"])
def test_terms_tile_the_observation_and_are_explained(name):
    policy = make_policy("env=paper" if name == "paper" else "env=default")
    names = [*policy.observations]
    if name == "all":
        names = [*TERMS]
        observation = replace(policy.env.observation, terms=dict.fromkeys(names, 1.0))
        policy = replace(policy, env=replace(policy.env, observation=observation))
    layout = describe(policy, {})
    assert json.loads(json.dumps(layout)) == layout
    assert (layout["clock"] is None) == (name == "paper")
    rows, end = layout["observation"]["terms"], 0
    assert [row["name"] for row in rows] == names
    for row in rows:
        assert row["start"] == end
        assert row["meaning"]
        assert len(row["units"]) == row["width"], row["name"]
        assert len(row["components"]) == row["width"] or row["name"] == "height_scan"
        end += row["width"]
    assert end == layout["observation"]["size"]


def test_gains_limits_and_scales_are_the_robots():
    policy = make_policy("robot.gains.capstan.kp=2.2", "env.action.scale.slide=0.07")
    joints, motors = (
        {row["name"]: row for row in describe(policy, {})["action"][part]}
        for part in ("joints", "motors")
    )
    assert (tuple(joints), tuple(motors)) == (JOINTS, MOTORS)
    slide, foot = joints["right_slide"], joints["left_upper_foot"]
    assert (slide["scale"], slide["unit"]) == (0.07, "m")
    assert (slide["lower"], slide["upper"]) == (-0.4, 0.4)
    assert (foot["actuated"], foot["scale"]) == (False, 0.0)
    values = ("kp", "kd", "torque_limit", "stall_torque", "no_load_speed", "rotor_inertia")
    found = [motors["right_leg_2"][name] for name in values]
    assert found == [2.2, 0.047, 9.0, 18.0, 120.0, 6.25e-4]


def test_a_knee_is_in_rad():
    layout = describe(replace(make_policy(), robot=kneed()), {}, EstimatorConfig(*[0.1] * 8))
    assert {joint["unit"] for joint in layout["action"]["joints"]} == {"rad"}
    terms = {row["name"]: row["units"] for row in layout["observation"]["terms"]}
    assert set(terms["joint_positions"]) == {"rad"}
    assert set(terms["joint_velocities"]) == {"rad/s"}
    assert layout["estimator"] is None  # run_policy.py has it for legs that slide


def test_the_motors_take_targets_to_the_angles_that_the_procedure_says():
    policy = make_policy()
    targets = np.random.default_rng(2).uniform(-0.3, 0.3, 12)
    named = dict(zip(JOINTS, targets, strict=True))
    angles = [
        sum(share * named[joint] for joint, share in motor["joints"].items())
        for motor in describe(policy, {})["action"]["motors"]
    ]
    np.testing.assert_allclose(angles, motor_angles(targets), rtol=1e-12)


def test_a_zero_action_is_the_nominal_pose_or_the_gait():
    plain, about = make_policy("env.action.offset=nominal"), make_policy("env.action.offset=gait")
    gaits = gait_table().joints
    np.testing.assert_array_equal(reference_table(about).values, gaits.values)
    found = describe(about, {})["reference"]
    assert [describe(p, {})["action"]["offset"] for p in (plain, about)] == ["nominal", "gait"]
    assert found["shape"] == list(gaits.values.shape)
    assert found["vx"] == gaits.times.vx.tolist()
    nominal = [joint["nominal"] for joint in describe(plain, {})["action"]["joints"]]
    for phase in (0.0, 0.4, 0.9):
        pose = reference_table(plain).at(np.zeros((1, 3)), np.array([phase]))
        np.testing.assert_array_equal(pose[0], nominal)
