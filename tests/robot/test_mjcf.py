"""The prismatic MuJoCo model and its kinematics."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from slider.core.config.compose import compose
from slider.robot import names
from slider.robot.kinematics import (
    foot_ends,
    leg_points,
    quaternion_from_tilt,
    rotation_from_quaternion,
    standing_height,
)
from slider.robot.mjcf import SimulationOptions, build_model, nominal_qpos

ROBOT = compose([], Path(__file__).parents[2] / "conf").robot


@pytest.fixture(scope="module")
def model():
    return build_model(ROBOT, SimulationOptions())


@pytest.fixture
def data(model):
    data = mujoco.MjData(model)
    data.qpos[:] = nominal_qpos(ROBOT)
    return data


def test_joints_actuators_and_mass(model):
    assert tuple(model.joint(i).name for i in range(1, model.njnt)) == names.JOINTS
    assert model.nu == 10
    assert not any("upper_foot" in model.actuator(i).name for i in range(model.nu))
    assert model.body_mass.sum() == pytest.approx(12.5248, abs=1e-9)
    assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
    assert model.na == 0


def test_slide_grows_with_the_leg_and_pitch_turns_about_y(model, data):
    data.qpos[7 + names.JOINTS.index("left_slide")] = 0.05
    data.qpos[7 + names.JOINTS.index("right_hip_pitch")] = 0.3
    mujoco.mj_kinematics(model, data)
    hip = data.body("left_hip_pitch").xpos
    assert hip[2] - data.body("left_foot").xpos[2] == pytest.approx(0.64 + 0.05)
    offset = data.body("right_foot").xpos - data.body("right_hip_pitch").xpos
    np.testing.assert_allclose(offset, [-0.64 * np.sin(0.3), 0, -0.64 * np.cos(0.3)], atol=1e-12)


def effort(model, data, joint: str, error: float, speed: float) -> float:
    """Actuator effort at a position error and a joint speed."""
    index = names.JOINTS.index(joint)
    data.qvel[:] = 0.0
    data.qvel[6 + index] = speed
    data.ctrl[:] = 0.0
    actuator = model.actuator(joint).id
    data.ctrl[actuator] = data.qpos[7 + index] + error
    mujoco.mj_forward(model, data)
    return float(data.actuator_force[actuator])


@pytest.mark.parametrize("joint", ["left_hip_pitch", "right_slide", "left_ankle"])
def test_drives_are_pd_bounded_by_effort_and_by_the_torque_speed_line(model, data, joint):
    name = joint.split("_", 1)[1]
    gains, limit, drive = ROBOT.gains[name], ROBOT.limits[name], ROBOT.drives[name]
    error = 0.2 * limit.effort / gains.kp
    speed = 0.1 * limit.effort / gains.kd * 0.5
    expected = gains.kp * error - gains.kd * speed
    assert effort(model, data, joint, error, speed) == pytest.approx(expected, rel=1e-9)
    large = 50 * limit.effort / gains.kp
    assert effort(model, data, joint, large, 0.0) == pytest.approx(limit.effort)
    fast = 0.8 * limit.speed
    left = drive.stall_ratio * limit.effort * (1 - fast / limit.speed)
    assert left < limit.effort
    assert effort(model, data, joint, large, fast) == pytest.approx(left, rel=1e-9)
    assert effort(model, data, joint, large, limit.speed) == pytest.approx(0.0, abs=1e-9)


def test_stands_on_two_lines(model, data):
    for _ in range(400):
        data.ctrl[:] = 0.0
        mujoco.mj_step(model, data)
    nominal = nominal_qpos(ROBOT)[2]
    assert nominal - 0.02 < data.qpos[2] < nominal
    assert data.ncon == 4  # two ends per foot
    for contact in data.contact:
        side = "left" if contact.pos[1] > 0 else "right"
        middle = data.sensor(f"{side}_sole_position").data
        assert abs(contact.pos[1] - middle[1]) < 2e-3  # on the line
        assert abs(abs(contact.pos[0] - middle[0]) - 0.085) < 2e-3  # at its ends
    forces = [data.sensor(f"{side}_foot_force").data[2] for side in names.SIDES]
    assert np.abs(forces).sum() == pytest.approx(model.body_mass.sum() * 9.81, rel=1e-3)
    assert data.sensor("base_contact").data[0] == 0


def test_a_fallen_base_touches_the_ground(model, data):
    data.qpos[2] = 0.0
    mujoco.mj_forward(model, data)
    assert data.sensor("base_contact").data[0] > 0


def test_foot_ends_are_where_mujoco_has_them(model, data):
    rng = np.random.default_rng(4)
    for _ in range(20):
        tilt = rng.normal(0, 0.3, (1, 2))
        joints = rng.uniform(-0.3, 0.3, (1, 12))
        data.qpos[3:7] = quaternion_from_tilt(tilt[:, 0], tilt[:, 1])[0]
        data.qpos[7:] = joints[0]
        mujoco.mj_kinematics(model, data)
        rotation = rotation_from_quaternion(data.qpos[None, 3:7])
        np.testing.assert_allclose(rotation[0].ravel(), data.body("base").xmat, atol=1e-12)
        ends = foot_ends(ROBOT.geometry, rotation, joints)[0] + data.qpos[:3]
        for leg, side in enumerate(names.SIDES):
            geom = data.geom(names.foot(side))
            axis = geom.xmat.reshape(3, 3)[:, 2] * 0.085
            expected = {tuple(np.round(geom.xpos + s * axis - [0, 0, 0.006], 9)) for s in (1, -1)}
            assert {tuple(np.round(end, 9)) for end in ends[leg]} == expected


def test_leg_points_are_where_mujoco_has_them(model, data):
    rng = np.random.default_rng(6)
    for _ in range(20):
        tilt, joints = rng.normal(0, 0.3, (1, 2)), rng.uniform(-0.3, 0.3, (1, 12))
        data.qpos[3:7] = quaternion_from_tilt(tilt[:, 0], tilt[:, 1])[0]
        data.qpos[7:] = joints[0]
        mujoco.mj_kinematics(model, data)
        rotation = rotation_from_quaternion(data.qpos[None, 3:7])
        points = leg_points(ROBOT.geometry, rotation, joints)[0] + data.qpos[:3]
        for leg, side in enumerate(names.SIDES):
            hip, foot, top = (data.body(f"{side}_{n}") for n in ("hip_pitch", "foot", "upper_foot"))
            for found, body in zip(points[leg], (hip, foot, top), strict=False):
                np.testing.assert_allclose(found, body.xpos, atol=1e-12)
            ends = np.array([[-ROBOT.geometry.heel, 0, 0.045], [ROBOT.geometry.toe, 0, 0.045]])
            expected = top.xpos + ends @ top.xmat.reshape(3, 3).T
            np.testing.assert_allclose(points[leg, 3:], expected, atol=1e-12)


def test_standing_height_puts_the_lowest_foot_point_on_the_ground():
    rng = np.random.default_rng(5)
    tilt, joints = rng.normal(0, 0.1, (8, 2)), rng.uniform(-0.1, 0.1, (8, 12))
    rotation = rotation_from_quaternion(quaternion_from_tilt(tilt[:, 0], tilt[:, 1]))
    height = standing_height(ROBOT.geometry, rotation, joints)
    ends = foot_ends(ROBOT.geometry, rotation, joints)
    np.testing.assert_allclose(ends[..., 2].min(axis=(1, 2)) + height, 0.0, atol=1e-12)
    upright = standing_height(ROBOT.geometry, np.eye(3)[None], np.zeros((1, 12)))
    assert upright[0] == pytest.approx(nominal_qpos(ROBOT)[2])


@pytest.mark.parametrize("joint", ["left_hip_pitch", "right_slide", "left_ankle"])
def test_torque_drives_have_the_same_limits(joint):
    model = build_model(ROBOT, SimulationOptions(actuation="torque"))
    data, name = mujoco.MjData(model), joint.split("_", 1)[1]
    limit, drive = ROBOT.limits[name], ROBOT.drives[name]
    index, actuator = names.JOINTS.index(joint), model.actuator(joint).id

    def force(torque: float, speed: float) -> float:
        data.qvel[:], data.ctrl[:] = 0.0, 0.0
        data.qvel[6 + index], data.ctrl[actuator] = speed, torque
        mujoco.mj_forward(model, data)
        return float(data.actuator_force[actuator])

    half, fast = 0.5 * limit.effort, 0.8 * limit.speed
    assert force(half, 0.0) == pytest.approx(half)
    assert force(-half, fast) == pytest.approx(-half)
    assert force(3 * limit.effort, 0.0) == pytest.approx(limit.effort)
    left = drive.stall_ratio * limit.effort * (1 - fast / limit.speed)
    assert force(limit.effort, fast) == pytest.approx(left, rel=1e-9)
    assert force(limit.effort, limit.speed) == pytest.approx(0.0, abs=1e-9)


def test_position_and_torque_drives_differ_in_their_input_only(model):
    torque = build_model(ROBOT, SimulationOptions(actuation="torque"))
    for field in ("dof_armature", "dof_damping", "jnt_range", "body_mass", "body_inertia"):
        np.testing.assert_array_equal(getattr(torque, field), getattr(model, field))
    assert torque.na == 0
