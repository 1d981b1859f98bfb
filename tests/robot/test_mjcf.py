"""The prismatic MuJoCo model and its kinematics."""

import mujoco
import numpy as np
import pytest

from slider.robot import names
from slider.robot.mjcf import SimulationOptions, build_model, nominal_qpos
from slider.robot.scene import aim
from slider.robot.transmission import Transmission
from tests.config.composed import composed
from tests.env.synthetic import JOINTS, MOTORS
from tests.robot.lopsided import with_soles

ROBOT = composed().robot


@pytest.fixture(scope="module")
def model():
    return build_model(ROBOT, SimulationOptions())


def test_joints_actuators_and_mass(model):
    assert tuple(model.joint(i).name for i in range(1, model.njnt)) == JOINTS
    assert tuple(model.actuator(i).name for i in range(model.nu)) == MOTORS
    assert model.body_mass.sum() == pytest.approx(12.5248, abs=1e-9)
    assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
    assert model.na == 0


def test_stands_on_two_lines(model):
    data = mujoco.MjData(model)
    data.qpos[:] = nominal_qpos(ROBOT)
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
        assert -2e-3 < contact.dist < -2e-4  # soles give way by a millimetre
    forces = [data.sensor(f"{side}_foot_force").data[2] for side in names.SIDES]
    assert np.abs(forces).sum() == pytest.approx(model.body_mass.sum() * 9.81, rel=1e-3)
    assert data.sensor("base_contact").data[0] == 0


def test_position_and_torque_drives_differ_in_their_input_only(model):
    torque = build_model(ROBOT, SimulationOptions(actuation="torque"))
    inertia = ("dof_armature", "tendon_armature", "body_mass", "body_inertia")
    for field in (*inertia, "dof_damping", "jnt_range", "wrap_prm", "pair_geom1", "pair_geom2"):
        np.testing.assert_array_equal(getattr(torque, field), getattr(model, field))
    assert torque.na == 0


# A pose for each of the pairs, as the left leg's part of it and the right leg's: only they touch.
INWARD = {"hip_yaw": -0.5, "hip_roll": -0.1}
OUTWARD = {"hip_yaw": -0.5, "hip_roll": 0.21}
FOOT_AT_TUBE = {"slide": -0.2, "hip_roll": -0.36}
UPPER_AT_TUBE = {"slide": 0.05, "hip_roll": 0.2}
TUBE_AT_UPPER = {"slide": -0.1, "hip_roll": 0.33}
POSES = {
    ("foot", "foot"): (INWARD, INWARD),
    ("tube", "tube"): ({"hip_roll": -0.16}, {"hip_roll": -0.16}),
    ("foot", "tube"): (FOOT_AT_TUBE, {"hip_roll": -0.05}),
    ("upper_foot", "upper_foot"): (OUTWARD, OUTWARD),
    ("upper_foot", "tube"): (UPPER_AT_TUBE, TUBE_AT_UPPER),
    ("tube", "base"): ({"hip_roll": 0.45}, {}),
}
POSES |= {parts[::-1]: legs[::-1] for parts, legs in POSES.items()}


def posed(model, left: dict[str, float], right: dict[str, float]) -> mujoco.MjData:
    """High above the ground, held by the motors; the right leg mirrors what it is given."""
    data = mujoco.MjData(model)
    data.qpos[:] = nominal_qpos(ROBOT)
    data.qpos[2] += 2.0
    for side, sign, leg in (("left", 1.0, left), ("right", -1.0, right)):
        for joint, value in leg.items():
            turned = sign if joint in ("hip_yaw", "hip_roll") else 1.0
            data.qpos[7 + JOINTS.index(f"{side}_{joint}")] = turned * value
    data.ctrl[:] = Transmission.of(ROBOT).angles(data.qpos[7:])
    mujoco.mj_forward(model, data)
    return data


def contact_forces(model, data) -> dict[frozenset[str], float]:
    """Pair of geoms → greatest normal force [N]."""
    forces, force = {}, np.zeros(6)
    for index, contact in enumerate(data.contact):
        pair = frozenset(model.geom(int(geom)).name for geom in contact.geom)
        mujoco.mj_contactForce(model, data, index, force)
        forces[pair] = max(forces.get(pair, 0.0), float(force[0]))
    return forces


def geom(side: str, part: str) -> str:
    return part if part == "base" else f"{side}_{part}"


@pytest.mark.parametrize("parts", POSES, ids="-".join)
def test_legs_that_are_at_the_same_place_touch(model, parts):
    data = posed(model, *POSES[parts])
    pair = frozenset((geom("left", parts[0]), geom("right", parts[1])))
    forces = contact_forces(model, data)
    assert set(forces) == {pair}
    assert forces[pair] > 1.0
    np.testing.assert_allclose(data.qfrc_constraint[:6], 0.0, atol=1e-9)  # inside of the robot
    lower, upper = ROBOT.joint_ranges
    assert ((data.qpos[7:] >= lower) & (data.qpos[7:] <= upper)).all()
    for side in names.SIDES:
        assert not data.sensor(f"{side}_foot_force").data.any(), "not a force of the ground"
        assert not data.sensor(f"{side}_tube_contact").data.any()
    assert not data.sensor("base_contact").data.any()


@pytest.mark.parametrize("side", names.SIDES)
def test_a_tube_touches_the_other_hip(model, side):
    """Only beyond the range of the roll: within it the tube's line passes the hip at 0.117 m."""
    lying = {"hip_roll": 1.35}
    data = posed(model, *((lying, {}) if side == "left" else ({}, lying)))
    other = names.SIDES[1 - names.SIDES.index(side)]
    assert frozenset((names.tube(side), f"{other}_hip")) in contact_forces(model, data)


def test_in_the_nominal_pose_the_legs_touch_nothing(model):
    assert posed(model, {}, {}).ncon == 0
    standing = mujoco.MjData(model)
    standing.qpos[:] = nominal_qpos(ROBOT)
    standing.qpos[2] -= 0.001
    mujoco.mj_forward(model, standing)
    floor = {frozenset((names.FLOOR, names.foot(side))) for side in names.SIDES}
    assert set(contact_forces(model, standing)) == floor


def test_the_friction_of_legs_is_the_feets(model):
    assert len(POSES) == model.npair - 2  # but those of the hips
    assert model.npair == len(names.LEG_PAIRS) + len(names.BASE_PAIRS)
    np.testing.assert_array_equal(model.pair_friction[:, :2], 0.75)
    np.testing.assert_array_equal(model.pair_dim, 3)


def test_a_leg_with_a_sole_has_no_upper_foot():
    model = build_model(with_soles(ROBOT, 0.05, 0.04), SimulationOptions())
    for side in names.SIDES:
        assert model.geom(f"{side}_upper_foot").rbound < 0.01
        assert model.geom(names.foot(side)).size[1] == 0.025


@pytest.mark.parametrize(("name", "axis", "sign"), [("side", 1, 1.0), ("front", 0, -1.0)])
def test_where_a_camera_looks(name, axis, sign):
    """From the right to the left (+y), and from the front backwards (−x); a little down."""
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody/></mujoco>")
    scene, camera = mujoco.MjvScene(model, 10), mujoco.MjvCamera()
    aim(camera, name, 2.0)
    data = mujoco.MjData(model)
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, 7, scene)
    forward = np.array(scene.camera[0].forward)
    assert sign * forward[axis] > 0.9
    assert -0.3 < forward[2] < 0.0
    assert np.linalg.norm(scene.camera[0].pos) == pytest.approx(2.0, abs=0.1)
