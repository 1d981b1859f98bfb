"""Robots from model files: our own through the same door, a URDF in frames of any direction."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from slider.cli import main
from slider.config.compose import compose
from slider.config.model_file import LINKS, read_model
from slider.config.robot import RobotConfig, parameters
from slider.core.errors import UserError
from slider.robot.mjcf import SimulationOptions, build_spec
from tests.robot.lopsided import lopsided

CONF = Path(__file__).parents[2] / "conf"
SLIDER = compose([], CONF).robot
ROLES = {
    "base": "base",
    "joints": {name: [f"left_{name}", f"right_{name}"] for name in LINKS},
}
AXES = {"hip_yaw": [0, 0, 1], "hip_roll": [1, 0, 0], "slide": [0, 0, -1]}


def mjcf(robot: RobotConfig, folder: Path) -> Path:
    spec = build_spec(robot, SimulationOptions())
    spec.compile()
    path = folder / "robot.xml"
    path.write_text(spec.to_xml(), encoding="utf-8")
    return path


@pytest.mark.parametrize("robot", [SLIDER, lopsided()], ids=["slider", "lopsided"])
@pytest.mark.parametrize("side", [None, "right"])
def test_our_own_model_gives_the_numbers_that_it_was_built_from(robot, side, tmp_path):
    found = read_model(mjcf(robot, tmp_path), ROLES | {"side": side})
    assert found.held == {}
    assert found.differs[0] < 1e-6
    for name, link in vars(robot.links).items():
        for quantity, value in vars(link).items():
            given = found.values["links"][name][quantity]
            np.testing.assert_allclose(given, value, atol=1e-6, err_msg=f"{name}.{quantity}")
    for name, place in vars(robot.geometry.axes).items():
        np.testing.assert_allclose(found.values["geometry"]["axes"][name], place, atol=1e-6)
    for name in ("leg_length", "upper_foot_height"):
        expected = getattr(robot.geometry, name)
        assert found.values["geometry"][name] == pytest.approx(expected, abs=1e-6)
    for name, joint in robot.joints.items():
        given = found.values["joints"][name]
        ends = joint.lower, joint.upper, joint.damping
        assert (given["lower"], given["upper"], given["damping"]) == pytest.approx(ends, abs=1e-6)
        drive = robot.drives.get(name)
        rotor = drive.inertia if drive else 0.0
        assert given["armature"] == pytest.approx(joint.armature + rotor, abs=1e-6)


def urdf(robot: RobotConfig, folder: Path) -> Path:
    """Links in frames of random directions; an arm on a hinge, and a box that is fixed."""
    rng, parts = np.random.default_rng(3), []
    frames = {"base": np.eye(3)}

    def link(name: str, turn: np.ndarray, mass: float, com: Any, inertia: np.ndarray) -> None:
        frames[name] = turn
        x, y, z = turn.T @ com
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = (turn.T @ inertia @ turn).tolist()
        parts.append(
            f'<link name="{name}"><inertial><origin xyz="{x} {y} {z}"/><mass value="{mass}"/>'
            f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="{xy}" ixz="{xz}" iyz="{yz}"/>'
            "</inertial></link>"
        )

    def joint(name: str, kind: str, parent: str, child: str, place: Any, axis: Any) -> None:
        x, y, z = frames[parent].T @ place
        turn = Rotation.from_matrix(frames[parent].T @ frames[child])
        roll, pitch, yaw = turn.as_euler("xyz")
        along = " ".join(map(str, frames[child].T @ axis))
        lower, upper = (-0.4, 0.3) if name == "right_hip_roll" else (-0.3, 0.4)
        parts.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{x} {y} {z}" rpy="{roll} {pitch} {yaw}"/><axis xyz="{along}"/>'
            f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/>'
            '<dynamics damping="0.5"/>'
            "</joint>"
        )

    base = robot.links.base
    link("base", np.eye(3), base.mass - 0.5, base.com, base.tensor)
    for name, kind in (("arm", "revolute"), ("box", "fixed")):
        link(name, Rotation.random(random_state=rng).as_matrix(), 0.25, [0, 0, 0], 1e-5 * np.eye(3))
        joint(f"{name}_joint", kind, "base", name, base.com, [0, 1, 0])
    for side, mirror in (("left", np.ones(3)), ("right", np.array([1.0, -1.0, 1.0]))):
        above = "base"
        places = dict(vars(robot.geometry.axes)) | {"slide": [0, 0, 0]}
        places["ankle"] = [0, 0, -robot.geometry.leg_length]
        for name in ("hip_yaw", "hip_roll", "hip_pitch", "slide", "ankle"):
            values, below = getattr(robot.links, LINKS[name]), f"{side}_{name}_link"
            turn = Rotation.random(random_state=rng).as_matrix()
            inertia = values.tensor * np.outer(mirror, mirror)
            link(below, turn, values.mass, mirror * values.com, inertia)
            kind, axis = "revolute", AXES.get(name, [0, 1, 0])
            if name == "hip_yaw":
                kind = "fixed"  # the machine lacks it
            joint(
                f"{side}_{name}",
                "prismatic" if name == "slide" else kind,
                above,
                below,
                mirror * places[name],
                axis,
            )
            above = below
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r">{"".join(parts)}</robot>', encoding="utf-8")
    return path


NO_YAW = {**ROLES["joints"], "hip_yaw": None, "upper_foot": None}


def test_a_urdf_in_any_frames_without_a_yaw_and_with_parts_that_are_held(tmp_path):
    robot = lopsided()
    found = read_model(urdf(robot, tmp_path), {"base": "base", "joints": NO_YAW})
    values, geometry = found.values, robot.geometry
    assert found.held == {"arm_joint": pytest.approx(0.25)}
    for name in ("roll", "pitch", "tube", "foot"):
        link, given = getattr(robot.links, name), values["links"][name]
        assert given["mass"] == pytest.approx(link.mass)
        np.testing.assert_allclose(given["com"], link.com, atol=1e-6)
        np.testing.assert_allclose(given["inertia"], link.inertia, atol=1e-6)
        np.testing.assert_allclose(given["products"], link.products, atol=1e-6)
    both = robot.links.base.mass + 2 * robot.links.yaw.mass  # the yaw links are welded to it
    assert values["links"]["base"]["mass"] == pytest.approx(both)
    assert values["links"]["yaw"]["mass"] == 0.01
    pitch = np.sum([values["geometry"]["axes"][name] for name in vars(geometry.axes)], axis=0)
    np.testing.assert_allclose(pitch, geometry.hip, atol=1e-6)
    assert values["geometry"]["leg_length"] == pytest.approx(geometry.leg_length)
    slide = {"lower": -0.3, "upper": 0.4, "damping": 0.5, "armature": 0.0}
    assert values["joints"]["slide"] == pytest.approx(slide)


def test_hinges_on_one_body_leave_light_links(tmp_path):
    """As many MJCF files have them: one body for the hip."""
    text, inertial = "", '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    for side, y in (("left", 0.1), ("right", -0.1)):
        hinges = "".join(
            f'<joint name="{side}_{name}" axis="{x} {y} {z}" range="-1 1"/>'
            for name, (x, y, z) in AXES.items()
            if name != "slide"
        )
        text += (
            f'<body pos="0 {y} 0">{inertial}{hinges}'
            f'<joint name="{side}_hip_pitch" axis="0 1 0" range="-1 1"/><body>{inertial}'
            f'<joint name="{side}_slide" type="slide" axis="0 0 1" range="-0.2 0.1"/>'
            f'<body pos="0 0 -0.6">{inertial}<joint name="{side}_ankle" axis="0 -1 0" '
            'range="-1 1"/></body></body></body>'
        )
    path = tmp_path / "robot.xml"
    text = f'<mujoco><worldbody><body name="base">{inertial}<freejoint/>{text}</body></worldbody>'
    path.write_text(f'{text}<compiler angle="radian"/></mujoco>', encoding="utf-8")
    found = read_model(path, ROLES | {"joints": ROLES["joints"] | {"upper_foot": None}})
    assert [found.values["links"][name]["mass"] for name in ("yaw", "roll", "pitch")] == [
        0.01,
        0.01,
        1,
    ]
    assert found.differs[0] < 1e-9
    slide = found.values["joints"]["slide"]
    assert (slide["lower"], slide["upper"]) == (-0.1, 0.2)  # our slide grows downwards


def test_a_robot_on_slider_may_have_a_motor_per_joint(folder):
    drive = "{torque: 10.0, speed: 3.0, stall_ratio: 2.0, inertia: 0.0}"
    motors = f"{{slide: {drive}, ankle: {drive}}}"
    gains = "{slide: {kp: 5000.0, kd: 100.0}, ankle: {kp: 50.0, kd: 1.0}}"
    text = f"{TEXT}\ncapstan: null\ndrives: {motors}\ngains: {gains}\n"
    (folder / "robot.yaml").write_text(text, encoding="utf-8")
    robot = compose([f"robot={folder}"], CONF).robot
    assert robot.leg_motors == ("hip_yaw", "hip_roll", "hip_pitch", "slide", "ankle")
    assert robot.drives["hip_roll"] == SLIDER.drives["hip_roll"]
    assert robot.virtual_knee == SLIDER.virtual_knee  # its leg is as long


TEXT = """
defaults: [slider, _self_]
name: mine
model: robot.xml
roles: {base: base, joints: {%s}}
links: {base: {mass: 3.0}}
provenance: {links: measured}
""" % ", ".join(f"{name}: [left_{name}, right_{name}]" for name in LINKS)  # noqa: UP031


@pytest.fixture
def folder(tmp_path) -> Path:
    path = tmp_path / "a robot"
    path.mkdir()
    mjcf(lopsided(), path)
    (path / "robot.yaml").write_text(TEXT, encoding="utf-8")
    return path


def test_a_typed_value_comes_before_that_of_the_model(folder):
    robot = compose([f"robot={folder}/robot.yaml"], CONF).robot
    tags = {item.path: item.provenance for item in parameters(robot)}
    assert robot.links.base.mass == 3.0
    np.testing.assert_allclose(robot.links.tube.com, lopsided().links.tube.com, atol=1e-6)
    assert robot.geometry.toe == SLIDER.geometry.toe
    assert (tags["links.tube.com"], tags["geometry.leg_length"]) == ("measured", "")


def test_the_robot_as_numbers_and_as_a_picture(folder, capsys):
    assert main(["robot", str(folder), "--conf", str(CONF), "--draw", "none/robot.png"]) == 1
    printed = capsys.readouterr()
    assert (printed.out, printed.err.count("\n")) == ("", 1)
    picture = folder / "robot.png"
    assert main(["robot", f"{folder}/robot.yaml", "--conf", str(CONF), "--draw", str(picture)]) == 0
    text = capsys.readouterr().out
    assert "held: nothing" in text
    assert "differ by 0.0%" in text
    assert picture.read_bytes().startswith(b"\x89PNG")
    row = next(line for line in text.splitlines() if line.startswith("hip_roll") and "%" in line)
    model = build_spec(compose([f"robot={folder}/robot.yaml"], CONF).robot, SimulationOptions())
    model = model.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    joint, leg = model.joint("left_hip_roll").id, model.body("left_hip_roll").id
    lever = [data.subtree_com[body][1] - data.xanchor[joint][1] for body in (1, leg)]
    total, own = model.body_subtreemass[1], model.body_subtreemass[leg]
    expected = 9.81 * (own * lever[1] - total * lever[0])  # weight above the left roll axis
    assert float(row.split()[4]) == pytest.approx(expected, abs=0.06)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("model: robot.xml", "model: none.xml", "robot.model: expected a model file"),
        ("model: robot.xml", "model: ../robot.xml", "expected a file beside this one"),
        ("base: base", "base: world", "robot.roles.base: expected the body of the base, found wo"),
        (
            "base: base",
            "base: pelvis",
            "robot.roles.base: expected a body of the model. Invalid name",
        ),
        ("left_slide", "left_knee", "expected a joint of the model. Invalid name"),
        ("[left_slide, right_slide]", "left_slide", "slide: expected a list, found"),
        ("hip_yaw: [", "hip: [", "joints: expected hip_yaw, hip_roll, hip_pitch, slide"),
        ("yaw: [left_hip_yaw,", "yaw: [left_hip_roll,", "expected each joint once"),
        ("base: base,", "base: base, side: top,", "robot.roles.side: expected 'left' or 'right'"),
        (
            "base: base,",
            "base: base, sides: left,",
            "unknown configuration key 'robot.roles.sides'",
        ),
        (
            "base: base,",
            "base: base, pose: {left_slide: far},",
            "left_slide: expected a valid number",
        ),
        ("base: base,", "base: base, pose: {left_hip_roll: 0.5},", "expected an axis along"),
    ],
)
def test_a_mistake_is_one_line(folder, before, after, message):
    assert before in TEXT
    (folder / "robot.yaml").write_text(TEXT.replace(before, after), encoding="utf-8")
    with pytest.raises(UserError) as error:
        compose([f"robot={folder}/robot.yaml"], CONF)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_meshes_and_textures_that_are_not_there_are_not_read(folder):
    path = folder / "robot.xml"
    text = path.read_text(encoding="utf-8")
    assets = '<asset><mesh name="m" file="m.stl"/><texture name="t" type="2d" file="t.png"/>'
    assets += '<material name="c" texture="t"/></asset><worldbody>'
    geom = '<joint name="left_slide"'
    assert geom in text
    text = text.replace("<worldbody>", assets, 1)
    text = text.replace(geom, f'<geom type="mesh" mesh="m" material="c"/>{geom}', 1)
    path.write_text(text, encoding="utf-8")
    robot = compose([f"robot={folder}"], CONF).robot
    np.testing.assert_allclose(robot.links.tube.com, lopsided().links.tube.com, atol=1e-6)


def test_swapped_legs_are_one_line(folder):
    text = TEXT.replace("left", "other").replace("right", "left").replace("other", "right")
    (folder / "robot.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(
        UserError, match=r"are left and right swapped\?\), found its ankle at y = -"
    ):
        compose([f"robot={folder}"], CONF)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('name="left_slide" type="slide"', 'name="left_slide" type="hinge"', "expected a slide"),
        ("<worldbody>", '<include file="robot.xml"/><worldbody>', "robot.model: robot.xml: "),
        ('mass="0.97"', 'mass="nan"', "robot.model: "),
        ('mass="0.97"', 'mass="1.97"', "expected legs that are alike, or roles.side"),
        ('range="-0.785 0.785"', 'range="-0.785 0.5"', "hip_roll joints that differ by"),
        ('range="-0.785 0.785"', 'range="0.2 0.785"', "a range that holds the nominal pose"),
        ('range="-0.785 0.785"', 'range="-45 45"', "a range that holds the nominal pose, in rad"),
        ("<compiler ", '<compiler inertiafromgeom="true" ', "expected masses of inertial elements"),
    ],
)
def test_a_model_that_does_not_fit_is_one_line(folder, before, after, message):
    path = folder / "robot.xml"
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after, 1), encoding="utf-8")
    with pytest.raises(UserError) as error:
        compose([f"robot={folder}/robot.yaml"], CONF)
    assert message in str(error.value)
    assert "\n" not in str(error.value)
