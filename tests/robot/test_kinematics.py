"""Turns about the vertical; feet and legs against MuJoCo."""

from collections.abc import Iterator

import mujoco
import numpy as np
import pytest

from slider.config.robot import RobotConfig
from slider.robot import names
from slider.robot.kinematics import (
    about_z,
    extend_leg,
    foot_ends,
    foot_motion,
    leg_extension_jacobian,
    leg_points,
    quaternion_from_tilt,
    rotation_from_quaternion,
    turn_to_heading,
)
from slider.robot.mjcf import SimulationOptions, build_model
from tests.config.composed import composed
from tests.robot.lopsided import kneed, lopsided, soled, turned

ROBOT = composed().robot
ROBOTS = pytest.mark.parametrize(
    "robot",
    [ROBOT, lopsided(), kneed(), turned(False), turned(True), soled()],
    ids=["slider", "lopsided", "kneed", "turned", "turned and kneed", "with soles"],
)


def test_the_way_back_and_the_rotation_matrix_agree_for_any_shape():
    rng = np.random.default_rng(4)
    vectors, yaw = rng.standard_normal((6, 5, 2)), rng.uniform(-4.0, 4.0, (6, 5))
    heading = turn_to_heading(vectors, yaw)
    np.testing.assert_allclose(turn_to_heading(heading, -yaw), vectors, atol=1e-14)
    matrices = about_z(yaw.ravel())[:, :2, :2]
    expected = np.einsum("nji,nj->ni", matrices, vectors.reshape(-1, 2))
    np.testing.assert_allclose(heading.reshape(-1, 2), expected, atol=1e-15)


def moving(robot: RobotConfig, seed: int) -> Iterator[tuple[mujoco.MjData, np.ndarray, np.ndarray]]:
    """MuJoCo's robot in 20 random poses and motions, its rotation and its joints (1, 12)."""
    model = build_model(robot, SimulationOptions())
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    for _ in range(20):
        tilt, joints = rng.normal(0, 0.3, (1, 2)), rng.uniform(-0.3, 0.3, (1, 12))
        data.qpos[3:7] = quaternion_from_tilt(tilt[:, 0], tilt[:, 1])[0]
        data.qpos[7:], data.qvel[3:] = joints[0], rng.standard_normal(15)
        mujoco.mj_forward(model, data)
        yield data, rotation_from_quaternion(data.qpos[None, 3:7]), joints


@ROBOTS
def test_points_of_the_legs_are_where_mujoco_has_them(robot):
    geometry = robot.geometry
    for data, rotation, joints in moving(robot, 4):
        np.testing.assert_allclose(rotation[0].ravel(), data.body("base").xmat, atol=1e-12)
        ends = foot_ends(geometry, rotation, joints)[0] + data.qpos[:3]
        points = leg_points(geometry, rotation, joints)[0] + data.qpos[:3]
        for leg, side in enumerate(names.SIDES):
            line = data.geom(names.foot(side))
            axis = line.xmat.reshape(3, 3)[:, 2] * (geometry.toe + geometry.heel) / 2
            low = line.xpos - [0, 0, geometry.foot_radius]
            if geometry.sole is not None:  # a box, and the middle of its ends below
                along, _, up = line.xmat.reshape(3, 3).T
                half, _, radius = data.model.geom(names.foot(side)).size
                axis, low = along * half, line.xpos - radius * up
            expected = {tuple(np.round(low + s * axis, 9)) for s in (1, -1)}
            assert {tuple(np.round(end, 9)) for end in ends[leg]} == expected
            if geometry.knee is not None:
                hip, knee, ankle = (
                    data.joint(f"{side}_{n}").xanchor for n in ("hip_pitch", "slide", "ankle")
                )
                np.testing.assert_allclose(points[leg, :3], [hip, ankle, knee], atol=1e-12)
                continue
            bodies = [data.body(f"{side}_{n}") for n in ("hip_pitch", "foot", "upper_foot")]
            upper = np.array([[-geometry.heel, 0, 0.045], [geometry.toe, 0, 0.045]])
            upper = bodies[2].xpos + upper @ bodies[2].xmat.reshape(3, 3).T
            places = [*(body.xpos for body in bodies), *upper]
            np.testing.assert_allclose(points[leg], places, atol=1e-12)


@ROBOTS
def test_the_feet_move_as_mujoco_moves_them_while_the_base_origin_rests(robot):
    velocity = np.zeros(6)
    for data, rotation, joints in moving(robot, 6):
        turning, rates = rotation @ data.qvel[3:6], data.qvel[None, 6:]
        motion = foot_motion(robot.geometry, rotation, turning, joints, rates)
        for leg, side in enumerate(names.SIDES):
            body = data.body(names.foot(side)).id
            kind = mujoco.mjtObj.mjOBJ_XBODY
            mujoco.mj_objectVelocity(data.model, data, kind, body, velocity, 0)
            arms = motion.positions[0, leg] + data.qpos[:3] - data.xpos[body]
            expected = velocity[3:] + np.cross(velocity[:3], arms)
            np.testing.assert_allclose(motion.velocities[0, leg], expected, atol=1e-12)
            hip, ankle = (data.joint(f"{side}_{name}").xanchor for name in ("hip_pitch", "ankle"))
            axis = (hip - ankle) / np.linalg.norm(hip - ankle)
            if robot.geometry.knee is None:
                axis = data.body(f"{side}_slide").xmat[2::3]  # of the tube
            np.testing.assert_allclose(motion.axes[0, leg], axis, atol=1e-12)


def leg_of(robot: RobotConfig, joints: np.ndarray, side: str) -> tuple[np.ndarray, np.ndarray]:
    """From hip to ankle (3,) [m], and along the foot's line (3,), in MuJoCo."""
    model = build_model(robot, SimulationOptions())
    data = mujoco.MjData(model)
    data.qpos[7:] = joints
    mujoco.mj_kinematics(model, data)
    leg = data.joint(f"{side}_ankle").xanchor - data.joint(f"{side}_hip_pitch").xanchor
    return leg, data.body(names.foot(side)).xmat[::3]


@ROBOTS
@pytest.mark.parametrize(("leg", "side"), enumerate(names.SIDES))
@pytest.mark.parametrize("extension", [-0.2, 0.0, 0.3])
def test_a_leg_that_stretches_keeps_its_direction_and_the_foot_s(robot, extension, leg, side):
    joints, step = np.random.default_rng(8).uniform(-0.2, 0.2, (1, 12)), 1e-6
    first = leg * names.LEG_SIZE
    joints[0, first + names.EXTENSION] = extension
    if robot.geometry.knee is None:
        joints[0, first : first + 3] = 0.0  # else the slide is not along the leg

    def moved(change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        there = 1.0 * joints[0]
        there[first : first + names.LEG_GAIT_JOINTS] += change
        return leg_of(robot, there, side)

    (before, line), way = moved(0.0), leg_extension_jacobian(robot.geometry, joints, leg)[0]
    ends = [moved(sign * step * way) for sign in (1, -1)]
    grown, turned_line = ((after - then) / (2 * step) for after, then in zip(*ends, strict=True))
    np.testing.assert_allclose(turned_line, 0.0, atol=1e-7)
    assert grown @ before / np.linalg.norm(before) == pytest.approx(1.0, abs=1e-6)
    after, line_after = moved(extend_leg(robot.geometry, joints, leg, np.array([-0.04]))[0])
    np.testing.assert_allclose(line_after, line, atol=1e-12)
    assert np.linalg.norm(before) - np.linalg.norm(after) == pytest.approx(0.04, abs=1e-12)


@pytest.mark.parametrize("robot", [kneed(), turned(True)], ids=["kneed", "turned"])
def test_a_leg_with_a_knee_is_at_most_almost_straight(robot):
    geometry, straight = robot.geometry, np.zeros((1, 12))
    straight[0, names.EXTENSION] = -geometry.bend
    most = np.abs(leg_extension_jacobian(geometry, straight, 0)).max()
    assert most < 1.0 / (0.03 * geometry.leg_length)
    joints = np.zeros(12)
    joints[: names.LEG_GAIT_JOINTS] = extend_leg(geometry, np.zeros((1, 12)), 0, np.array([1.0]))[0]
    length = np.linalg.norm(leg_of(robot, joints, "left")[0])
    assert length == pytest.approx(0.995 * 0.8, abs=1e-3)
