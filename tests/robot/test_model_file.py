"""Robots from model files: our own through the same door, a URDF in frames of any direction."""

import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from omegaconf import OmegaConf
from scipy.spatial.transform import Rotation

from slider.cli import main
from slider.composition.robot_file import read
from slider.config.convert import from_dict, to_dict
from slider.config.parameters import parameters
from slider.config.robot import HIP_JOINTS, LINKS, RobotConfig, Sole
from slider.core.errors import UserError
from slider.core.files import flatten
from slider.robot.mjcf import SimulationOptions, build_spec
from slider.robot.model_file import ModelFile, read_model
from tests.config.composed import CONF, composed
from tests.robot.lopsided import kneed, lopsided, turned, with_soles

SLIDER = composed().robot
ROLES = {"base": "base", "joints": {name: [f"left_{name}", f"right_{name}"] for name in LINKS}}
NO_YAW = {"base": "base", "joints": ROLES["joints"] | {"hip_yaw": None, "upper_foot": None}}
KNEED = {  # in our own model a knee has the slide's name
    "base": "base",
    "joints": {
        "knee" if name == "slide" else name: pair if name != "upper_foot" else None
        for name, pair in ROLES["joints"].items()
    },
}
AXES = {"hip_yaw": [0, 0, 1], "slide": [0, 0, -1], "hip_roll": [1, 0, 0], "ankle_roll": [1, 0, 0]}


def model_of(file: Path) -> ModelFile:
    _, model = read(file)
    assert model is not None
    return model


def mjcf(robot: RobotConfig, folder: Path) -> Path:
    return saved(build_spec(robot, SimulationOptions()), folder)


def saved(spec: mujoco.MjSpec, folder: Path) -> Path:
    spec.compile()
    path = folder / "robot.xml"
    path.write_text(spec.to_xml(), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "robot",
    [SLIDER, lopsided(), kneed(), turned(False), turned(True), kneed("unitree_g1_sole")],
    ids=["slider", "lopsided", "kneed", "turned", "turned and kneed", "sole"],
)
@pytest.mark.parametrize("side", [None, "right"])
def test_our_own_model_gives_the_numbers_that_it_was_built_from(robot, side, tmp_path):
    roles = ROLES
    if robot.geometry.sole is not None:
        roles = {"base": "base", "joints": rolls(KNEED["joints"])}
    elif robot.geometry.knee is not None:
        light = replace(robot.links.upper_foot, mass=1e-9, inertia=(1e-12,) * 3)
        robot, roles = replace(robot, links=replace(robot.links, upper_foot=light)), KNEED
    found = read_model(mjcf(robot, tmp_path), roles | {"side": side})
    assert sum(found.held.values()) < 1e-8
    assert found.differs[0] < 1e-6
    expected = flatten({name: to_dict(robot)[name] for name in found.values})
    for name, drive in robot.drives.items():
        if name in robot.joints:
            expected[f"joints.{name}.armature"] += drive.inertia
    given = flatten({k: v for k, v in found.values.items() if k not in ("drives", "gains")})
    assert {"links.tube.products", "geometry.axes.hip_yaw", "joints.slide.damping"} <= given.keys()
    for name, value in given.items():
        if value is None:
            assert expected.get(name) is None
        elif name.endswith("order"):
            assert tuple(value) == expected[name]
        elif "upper_foot" not in name or robot.geometry.knee is None:
            np.testing.assert_allclose(value, expected[name], 1e-5, 1e-6, err_msg=name)


def footed(folder: Path, x: float, y: float, turn: float = 0.0) -> Path:
    """SLIDER with feet that are boxes of 0.2 × 0.1 × 0.02 m, their middles beside the ankles."""
    spec = build_spec(SLIDER, SimulationOptions())
    for side, sign in (("left", 1.0), ("right", -1.0)):
        foot = spec.joint(f"{side}_ankle").parent
        for geom in list(foot.geoms):
            spec.delete(geom)
        place = [x, sign * y, -0.03]
        quat = [np.cos(turn / 2), 0.0, np.sin(turn / 2), 0.0]
        box = {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": [0.1, 0.05, 0.01], "quat": quat}
        foot.add_geom(name=f"{side}_sole", pos=place, contype=1, **box)
    for part in [*spec.pairs, *spec.sensors]:
        spec.delete(part)
    return saved(spec, folder)


@pytest.mark.parametrize("side", [None, "right"])
def test_the_line_is_in_the_middle_of_the_models_sole(side, tmp_path):
    path, roles = footed(tmp_path, 0.03, 0.02), ROLES | {"side": side}
    found = read_model(path, roles)
    sole = {"y": 0.12, "width": 0.1, "ankle_height": 0.04, "toe": 0.13, "heel": 0.07}
    assert found.foot == pytest.approx(sole, abs=1e-6)
    geometry, links = found.values["geometry"], found.values["links"]
    for name in ("ankle_height", "toe", "heel"):
        assert geometry[name] == pytest.approx(sole[name], abs=1e-6)
    assert sum(geometry["axes"][name][1] for name in HIP_JOINTS) == pytest.approx(0.12)
    assert links["tube"]["com"][1] == pytest.approx(SLIDER.links.tube.com[1] - 0.02)
    assert links["roll"]["com"][1] == pytest.approx(SLIDER.links.roll.com[1])
    typed = read_model(path, roles | {"foot_y": 0.09}).values["geometry"]["axes"]
    assert sum(typed[name][1] for name in HIP_JOINTS) == pytest.approx(0.09)
    width, depth = (np.ptp(np.array(outline)[:, 0]) for outline in found.outlines)
    assert (width, depth) == pytest.approx((0.2, 0.1), abs=1e-3)


def test_a_sole_that_is_tilted_in_the_models_zero_is_levelled(tmp_path):
    path = footed(tmp_path, 0.0, 0.0, 0.175)
    found = read_model(path, ROLES)
    assert "sole is tilted by -10.0° in its zero pose" in " ".join(found.remarks)
    assert found.pose["left_ankle"] == pytest.approx(-0.175, abs=1e-5)
    assert found.foot["toe"] - found.foot["heel"] == pytest.approx(2 * 0.03 * np.sin(0.175))
    pose = {"left_ankle": 0.0, "right_ankle": 0.0}
    (told,) = read_model(path, ROLES | {"pose": pose}).remarks
    assert (
        told == "the model's sole is not level in roles.pose: turn the ankle by -0.18 rad about y"
    )
    pose |= {"left_hip_pitch": -0.1, "right_hip_pitch": -0.1}
    told = " ".join(read_model(path, ROLES | {"pose": pose}).remarks)
    assert "left_hip_pitch is 0.0000 rad in place of -0.1, for a level sole" in told
    assert "the pose levels it" in told


def test_formulas_give_the_joints_from_those_of_the_model(tmp_path):
    """Of axes of either sign, and of a pose that is not the model's zero."""
    path = rolling(tmp_path) / XML
    text = path.read_text()
    for axis in (
        'right_hip_pitch" axis="0 1',
        'left_ankle" axis="0 1',
        'left_hip_yaw" axis="0 0 1',
    ):
        assert text.count(axis) == 1
        text = text.replace(axis, f"{axis[:-1]}-1")
    path.write_text(text)
    robot, formulas = composed(f"robot={tmp_path}").robot, model_of(tmp_path / YAML).formulas
    assert formulas["hip_yaw"] == "−left_hip_yaw, right_hip_yaw"
    datas = ours, theirs = [
        mujoco.MjData(model)
        for model in (
            build_spec(robot, SimulationOptions()).compile(),
            mujoco.MjModel.from_xml_path(str(path)),
        )
    ]
    theirs.qpos[7:] = np.random.default_rng(5).uniform(-0.4, 0.4, 12)
    given = {theirs.model.joint(k).name: float(theirs.qpos[6 + k]) for k in range(1, 13)}
    for name, pair in formulas.items():
        for side, formula in zip(("left", "right"), pair.split(", "), strict=True):
            ours.joint(f"{side}_{name}").qpos = eval(formula.replace("−", "-"), {}, given)
    ours.qpos[:7] = theirs.qpos[:7]
    for data in datas:
        mujoco.mj_kinematics(data.model, data)
        data.xanchor[:] -= data.xanchor[0]
    for name in given:
        off = np.cross(
            ours.joint(name).xanchor - theirs.joint(name).xanchor, ours.joint(name).xaxis
        )
        np.testing.assert_allclose(off, 0.0, atol=1e-4)


def test_a_plate_that_is_turned_compiles(tmp_path):
    """Its moments are A + B = C, up to a rounding."""
    plate = 'fullinertia="1e-5 3e-5 2e-5 0 0 0"'
    sole = ('fullinertia="3e-4 1e-3 1e-3 0 1e-4 0"', plate)
    pose = "pose: {left_ankle: -0.1, right_ankle: -0.1}, joints"
    change(rolling(tmp_path, sole) / YAML, "joints", pose)
    robot = composed(f"robot={tmp_path}").robot
    assert build_spec(robot, SimulationOptions()).compile().nv == 18


def test_a_knee_at_the_end_of_its_range_is_bent_to_the_other_side(tmp_path):
    """The leg is hyperextended by 0.1 rad in the zero pose, where the range ends."""
    shank = '"><inertial pos="-0.01 0 0.01" mass="0.1"'
    moved = (f"0 0 -0.3{shank}", f"{0.3 * np.sin(0.1):.6f} 0 {-0.3 * np.cos(0.1):.6f}{shank}")
    ends = ('slide" axis="0 1 0" range="-1.5 1.5"', 'slide" axis="0 1 0" range="0 2.5"')
    pose = model_of(rolling(tmp_path, moved, ends) / YAML).pose
    assert pose["left_slide"] == pytest.approx(0.1 + 0.5, abs=1e-4)


def test_motors_that_differ_between_the_legs_are_told(tmp_path):
    path = rolling(tmp_path) / XML
    path.write_text(path.read_text().replace('frcrange="-40 40"', 'frcrange="-30 30"', 1))
    told = " ".join(model_of(tmp_path / YAML).remarks)
    assert "torque of hip_yaw is 30, on the other leg 40" in told


@pytest.mark.parametrize("role", ["hip_yaw", "hip_roll", "knee"])
def test_a_pair_that_is_swapped_alone_is_told(role, tmp_path):
    name = "slide" if role == "knee" else role
    own, other = f"[left_{name}, right_{name}]", f"[right_{name}, left_{name}]"
    change(rolling(tmp_path) / YAML, own, other)
    found = f"found left and right of {name} swapped"
    with pytest.raises(UserError, match=f"^robot.roles.joints: expected joints .*, {found}"):
        model_of(tmp_path / YAML)


@pytest.mark.parametrize(
    ("x", "roles", "message"),
    [
        (0.03, {"forward": "-x"}, "(the base looks along x: roles.forward: x)"),
        (0.03, {"joints": {k: [*reversed(v)] for k, v in ROLES["joints"].items()}}, "are swapped)"),
    ],
)
def test_a_base_that_looks_backwards_is_told_from_legs_that_are_swapped(
    x, roles, message, tmp_path
):
    with pytest.raises(UserError, match=re.escape(message)):
        read_model(footed(tmp_path, x, 0.0), ROLES | roles)


def printed(folder: Path, text: str, capsys) -> str:
    """What ``slider robot`` says of a folder with this ``robot.yaml``."""
    (folder / "robot.yaml").write_text(text, encoding="utf-8")
    assert main(["robot", str(folder), "--conf", str(CONF)]) == 0
    return capsys.readouterr().out


def test_a_line_beside_the_models_sole_and_feet_behind_the_ankles_are_told(tmp_path, capsys):
    footed(tmp_path, 0.03, 0.02)
    text = TEXT.replace("roles: {", "geometry: {toe: 0.085}\nroles: {foot_y: 0.11, ")
    said = printed(tmp_path, text, capsys)
    assert "remark: y of the foot line is 0.110 m, of the model 0.120" in said
    assert "remark: toe of the foot line is 0.085 m, of the model 0.130" in said
    assert "remark: heel" not in said
    said = printed(tmp_path, SWAPPED.replace("roles: {", "roles: {forward: -x, "), capsys)
    assert "remark: the feet are behind the ankles" in said


def test_a_pose_that_turns_the_feet_is_told(tmp_path):
    robot = mjcf(SLIDER, tmp_path)
    assert read_model(robot, ROLES | {"pose": {}}).foot_rotation == pytest.approx(0.0, abs=1e-6)
    pose = {"left_ankle": 0.1, "right_ankle": 0.1}
    assert read_model(robot, ROLES | {"pose": pose}).foot_rotation == pytest.approx(0.1, abs=1e-6)


def apart(
    robot: RobotConfig, file: mujoco.MjModel, pose: dict[str, float], states: int = 100
) -> float:
    """Largest distance of axes [m], difference of their directions, or, with a sole, of the mass
    matrix by its diagonal, at random states.
    """
    sole = robot.geometry.sole is not None
    last = [name for name in robot.geometry.leg_joints if name != "upper_foot"]
    rng, worst = np.random.default_rng(3), 0.0
    model = build_spec(robot, SimulationOptions()).compile()
    datas = ours, theirs = mujoco.MjData(model), mujoco.MjData(file)
    masses = np.zeros((2, model.nv, model.nv))
    for _ in range(states):
        joints = rng.uniform(-0.5, 0.5, 12) * ((np.arange(12) % 6 < 5) | sole)
        ours.qpos[3:7] = theirs.qpos[3:7] = rng.standard_normal(4)
        ours.qpos[7:], theirs.qpos[7:] = joints, joints
        for name, angle in pose.items():
            theirs.joint(name).qpos += angle
        for data in datas:
            mujoco.mj_kinematics(data.model, data)
            mujoco.mj_comPos(data.model, data)
            mujoco.mj_crb(data.model, data)
            mujoco.mj_fullM(data.model, data, masses[int(data is theirs)])
            data.xanchor[:] -= data.xanchor[0]
        scale = np.sqrt(masses[1].diagonal())
        difference = np.abs(masses[0] - masses[1]) / np.outer(scale, scale)
        worst = max(worst, sole * difference.max())
        for name in [f"{side}_{name}" for side in ("left", "right") for name in last]:
            one, other = (data.joint(name) for data in datas)
            worst = max(worst, np.abs(one.xaxis - other.xaxis).max())
            off = np.cross(one.xanchor - other.xanchor, one.xaxis)  # no matter where on the axis
            worst = max(worst, np.abs(off).max())
    return worst


@pytest.mark.parametrize("bend", [0.4, 0.9])
def test_a_leg_of_any_axes_bent_by_an_angle_is_that_of_the_file(bend, tmp_path):
    """The sole is level, the ankle below the hip; the same axis of the other sign is seen."""
    path = mjcf(turned(True), tmp_path)
    found = read_model(path, KNEED | {"bend": bend})
    assert {name.removeprefix("left_") for name in found.pose} >= {*HIP_JOINTS, "slide", "ankle"}
    values = OmegaConf.to_container(OmegaConf.merge(to_dict(turned(True)), found.values))
    robot = from_dict(RobotConfig, values)
    assert abs(robot.geometry.bend) == pytest.approx(bend, abs=0.01)
    assert found.foot_rotation < 1e-5
    file = mujoco.MjModel.from_xml_path(str(path))
    assert apart(robot, file, found.pose) < 1e-5
    file.jnt_axis[file.joint("left_ankle").id, 2] *= -1.0
    assert apart(robot, file, found.pose) > 0.01


AT = 'range="-1.5 1.5" armature="0.01" actuatorfrcrange="-40 40"'
ROLL = '<body pos="0.02 0 -0.03"><inertial pos="0 0 0" mass="1" diaginertia="1e-3 1e-3 1e-3"/>'
PITCH = '<body><inertial pos="0 0 -0.15" mass="2" diaginertia="1e-2 1e-2 2e-3"/>'
ANKLE = ('ankle" axis="0 1 0"', 'ankle_roll" axis="1 0 0" pos="0.01 0 0"')  # [m]


def rolling(folder: Path, *changes: tuple[str, str]) -> Path:
    """A folder of a robot with knees, a talus and soles of 0.18 × 0.08 m, roll axes 2 cm down."""
    legs = "".join(
        f"""<body pos="0 {y} -0.05"><inertial pos="0.01 0 -0.02" mass="1.2"
        fullinertia="3e-3 2e-3 2e-3 0 2e-4 0"/><joint name="{side}_hip_yaw" axis="0 0 1" {AT}/>
        {ROLL}<joint name="{side}_hip_roll" axis="1 0 0" {AT}/>
        {PITCH}<joint name="{side}_hip_pitch" axis="0 1 0" {AT}/>
        <body pos="0 0 -0.3"><inertial pos="0.01 0 -0.1" mass="1.5" diaginertia="8e-3 8e-3 1e-3"/>
        <joint name="{side}_slide" axis="0 1 0" {AT}/>
        <body pos="0 0 -0.3"><inertial pos="-0.01 0 0.01" mass="0.1"
        fullinertia="2e-5 3e-5 2e-5 0 4e-6 0"/><joint name="{side}_{ANKLE[0]} {AT}/>
        <body pos="0 0 -0.02"><inertial pos="0.03 0 -0.02" mass="0.5"
        fullinertia="3e-4 1e-3 1e-3 0 1e-4 0"/><joint name="{side}_{ANKLE[1]} {AT}/>
        <geom type="box" size="0.09 0.04 0.01" pos="0.03 0 -0.03"/>
        </body></body></body></body></body></body>"""
        for side, y in (("left", 0.1), ("right", -0.1))
    )
    base = '<inertial pos="0 0 0.1" mass="10" diaginertia="0.2 0.2 0.1"/><freejoint/>'
    xml = f'<mujoco><compiler angle="radian"/><worldbody><body name="base">{base}{legs}</body>'
    xml += "</worldbody></mujoco>"
    for before, after in changes:
        assert xml.count(before) == 2, before
        xml = xml.replace(before, after)
    (folder / XML).write_text(xml, encoding="utf-8")
    roles = [*HIP_JOINTS, "slide", "ankle", "ankle_roll"]
    names = ", ".join(f"{name}: [left_{name}, right_{name}]" for name in roles)
    names = names.replace("slide:", "knee:")
    text = "defaults: [slider, _self_]\nname: mine\nmodel: robot.xml\n"
    (folder / YAML).write_text(f"{text}roles: {{base: base, joints: {{{names}}}}}\n")
    return folder


def test_an_ankle_that_rolls_is_that_of_the_file(tmp_path, capsys):
    """Talus, sole and motor of the roll; the robot moves as the file's, mass matrix included."""
    robot = composed(f"robot={rolling(tmp_path)}").robot
    assert robot.geometry.sole == Sole(roll_height=0.04, width=0.08)
    assert (robot.geometry.ankle_height, robot.links.talus.mass) == (0.06, 0.1)
    assert robot.links.talus.products == (0.0, 4e-6, 0.0)
    assert robot.links.foot.com == (0.03, 0.0, -0.02)  # from the axis, below the ankle
    assert robot.joints["ankle_roll"].upper == 1.5
    assert (robot.drives["ankle_roll"].torque, robot.gains["ankle_roll"].kp) == (40.0, 80.0)
    assert len(robot.leg_motors) == 6
    file = mujoco.MjModel.from_xml_path(str(tmp_path / XML))
    pose = model_of(tmp_path / YAML).pose
    assert apart(robot, file, pose) < 1e-5
    file.jnt_pos[file.joint("left_ankle_roll").id, 2] += 0.01
    assert apart(robot, file, pose) > 1e-3
    picture = tmp_path / "robot.png"
    assert main(["robot", str(tmp_path), "--conf", str(CONF), "--draw", str(picture)]) == 0
    said = capsys.readouterr().out
    assert "held: nothing" in said
    assert "talus" in said
    assert "remark" not in said


def mutations(value: Any) -> list[Any]:
    """A value, or each element of one, changed: by 2 %, zeros by 1e-4, directions by 0.01 rad."""
    if isinstance(value, float):
        return [1.02 * value or 1e-4]
    if np.linalg.norm(value) == pytest.approx(1.0):
        turned = (Rotation.from_rotvec(0.01 * axis).apply(value) for axis in np.eye(3))
        return [v.tolist() for v in turned if not np.allclose(v, value, atol=1e-3)]
    return [[*value[:i], *mutations(v), *value[i + 1 :]] for i, v in enumerate(value)]


def test_a_mutation_of_any_imported_number_is_seen(tmp_path):
    """Each mass, centre, inertia, anchor and direction of a leg and of the base, one at a time."""
    robot = composed(f"robot={rolling(tmp_path)}").robot
    file, found = mujoco.MjModel.from_xml_path(str(tmp_path / XML)), model_of(tmp_path / YAML)
    assert apart(robot, file, found.pose) < 1e-8
    given = flatten({name: found.values[name] for name in ("geometry", "links")})
    skipped = ("order", "toe", "heel", "width", "upper_foot", "upper_foot_height")  # no dynamics
    changes = [
        (name, other)
        for name, value in given.items()
        if name.rpartition(".")[2] not in skipped
        for other in mutations(value)
    ]
    seen = 0
    for name, other in changes:
        values = OmegaConf.create(to_dict(robot))
        OmegaConf.update(values, name, other)
        try:
            mutant = from_dict(RobotConfig, OmegaConf.to_container(values))
        except UserError:
            continue  # such as a base that is not symmetric
        assert apart(mutant, file, found.pose, states=3) > 1e-6, (name, other)
        seen += 1
    assert seen > 80


CROSS = """<inertial pos="-0.01 0 0.01" mass="0.1"
        fullinertia="2e-5 3e-5 2e-5 0 4e-6 0"/>"""


def test_a_cross_without_mass_is_light_and_a_typed_width_comes_first(tmp_path):
    width = "name: mine\ngeometry: {sole: {width: 0.05}}"
    change(rolling(tmp_path, (CROSS, "")) / YAML, "name: mine", width)
    robot = composed(f"robot={tmp_path}").robot
    assert robot.links.talus.mass == 0.001
    assert robot.geometry.sole == Sole(roll_height=0.04, width=0.05)


SWAP = [
    ('_ankle_roll" axis="1 0 0"', '_x" axis="0 1 0"'),
    ('_ankle" axis="0 1 0"', '_ankle_roll" axis="1 0 0"'),
    ('_x"', '_ankle"'),
]
BESIDE = [('pos="0.03 0 -0.03"', 'pos="0.03 0.006 -0.03"')]
BARE = [('<geom type="box" size="0.09 0.04 0.01" pos="0.03 0 -0.03"/>', "")]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (SWAP, "knee, ankle from the base to left_ankle, found hip_yaw, hip_roll, hip_pitch, kne"),
        ([('axis="1 0 0" pos', 'axis="1 0.02 0" pos')], "ankle_roll: expected an axis along x, fo"),
        (BESIDE, "an axis within 0.005 m of the foot's middle, y = 0.106 m, found y = 0.100 m"),
        (BARE, "geometry.ankle_height: expected a number in the robot's file, or the geometry of"),
    ],
    ids=["roll first", "tilted", "beside", "without geometry"],
)
def test_an_ankle_that_rolls_otherwise_is_refused(changes, message, tmp_path):
    rolling(tmp_path, *changes)
    with pytest.raises(UserError, match=re.escape(message)) as error:
        read(tmp_path / YAML)
    assert "\n" not in str(error.value)


def test_a_typed_knee_stays_and_the_rest_is_solved(tmp_path):
    typed = {"left_slide": 0.3, "right_slide": 0.3}
    found = read_model(mjcf(kneed(), tmp_path), KNEED | {"pose": typed})
    sides = {name.partition("_")[2] for name in found.pose}
    assert sides == {"hip_pitch", "ankle"}
    for name in sides:
        assert found.pose[f"left_{name}"] == pytest.approx(found.pose[f"right_{name}"], abs=1e-6)
    turn = sum(found.pose[f"left_{name}"] for name in sides)
    assert turn == pytest.approx(-0.3, abs=1e-5)
    assert not read_model(mjcf(kneed(), tmp_path), KNEED | {"pose": typed | found.pose}).pose


def text(*values: float) -> str:
    return " ".join(map(str, np.ravel(values)))


def urdf(robot: RobotConfig, folder: Path) -> Path:
    """Links in frames of random directions; an arm on a hinge, and a box that is fixed."""
    rng, parts = np.random.default_rng(3), []
    frames = {"base": np.eye(3)}

    def link(name: str, mass: float, com: Any, inertia: np.ndarray) -> None:
        turn = frames[name]
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = turn.T @ inertia @ turn
        parts.append(
            f'<link name="{name}"><inertial><origin xyz="{text(turn.T @ com)}"/>'
            f'<mass value="{mass}"/><inertia ixx="{xx}" iyy="{yy}" izz="{zz}" '
            f'ixy="{xy}" ixz="{xz}" iyz="{yz}"/></inertial></link>'
        )

    def joint(name: str, kind: str, parent: str, child: str, place: Any, axis: Any) -> None:
        frames[child] = Rotation.random(random_state=rng).as_matrix()
        turn = Rotation.from_matrix(frames[parent].T @ frames[child]).as_euler("xyz")
        lower, upper = (-0.4, 0.3) if name.startswith("right") and "roll" in name else (-0.3, 0.4)
        parts.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{text(frames[parent].T @ place)}" rpy="{text(turn)}"/>'
            f'<axis xyz="{text(frames[child].T @ axis)}"/><dynamics damping="0.5"/>'
            f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/></joint>'
        )

    base = robot.links.base
    link("base", base.mass - 0.5, base.com, base.tensor)
    for name, kind in (("arm", "revolute"), ("box", "fixed")):
        joint(f"{name}_joint", kind, "base", name, base.com, [0, 1, 0])
        link(name, 0.25, [0, 0, 0], 1e-5 * np.eye(3))
    kinds = {"hip_yaw": "fixed", "slide": "prismatic"}  # the machine lacks the yaw
    places: dict[str, Any] = {name: place for name, place, _ in robot.geometry.axes.chain()}
    places |= {"slide": np.zeros(3)}
    places["ankle"] = [0, 0, -robot.geometry.leg_length]
    if robot.geometry.sole is not None:
        places["ankle_roll"] = robot.geometry.ankle_roll
    below_of = LINKS | robot.geometry.links
    for side, mirror in (("left", np.ones(3)), ("right", np.array([1.0, -1.0, 1.0]))):
        above = "base"
        for name, place in places.items():
            values, below = getattr(robot.links, below_of[name]), f"{side}_{name}_link"
            kind, axis = kinds.get(name, "revolute"), AXES.get(name, [0, 1, 0])
            joint(f"{side}_{name}", kind, above, below, mirror * place, axis)
            link(below, values.mass, mirror * values.com, values.tensor * np.outer(mirror, mirror))
            above = below
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r">{"".join(parts)}</robot>', encoding="utf-8")
    return path


def test_a_urdf_in_any_frames_without_a_yaw_and_with_parts_that_are_held(tmp_path):
    robot, path = lopsided(), urdf(lopsided(), tmp_path)
    found = read_model(path, NO_YAW)
    assert read_model(path.rename(tmp_path / "robot.URDF"), NO_YAW) == found  # whatever its ending
    values, geometry = found.values, robot.geometry
    assert found.held == {"arm_joint": pytest.approx(0.25)}
    assert_links(values, robot, "roll", "pitch", "tube", "foot")
    both = robot.links.base.mass + 2 * robot.links.yaw.mass  # the yaw links are welded to it
    assert values["links"]["base"]["mass"] == pytest.approx(both)
    assert values["links"]["yaw"]["mass"] == 0.001
    pitch = np.sum([values["geometry"]["axes"][name] for name in geometry.axes.order], axis=0)
    np.testing.assert_allclose(pitch, geometry.hip, atol=1e-6)
    assert values["geometry"]["leg_length"] == pytest.approx(geometry.leg_length)
    slide = {"lower": -0.3, "upper": 0.4, "damping": 0.5, "armature": 0.0}
    assert values["joints"]["slide"] == pytest.approx(slide)
    assert "slide" not in values["drives"], "it has a capstan"


def assert_links(values: dict[str, Any], robot: RobotConfig, *names: str) -> None:
    for name in names:
        for quantity, value in vars(getattr(robot.links, name)).items():
            given = values["links"][name][quantity]
            np.testing.assert_allclose(given, value, atol=1e-6, err_msg=f"{name}.{quantity}")


def rolls(joints: dict[str, Any]) -> dict[str, Any]:
    """The roll of the ankle in the place of the upper foot."""
    others = {name: pair for name, pair in joints.items() if name != "upper_foot"}
    return others | {"ankle_roll": ["left_ankle_roll", "right_ankle_roll"]}


def test_a_urdf_of_sliding_legs_with_soles(tmp_path):
    """Without geometry of a foot its height and width are typed."""
    robot = with_soles(lopsided(), 0.07, 0.03)
    height = robot.geometry.ankle_height
    typed = {"capstan": None, "geometry.ankle_height": height, "geometry.sole.width": 0.07}
    roles = {"base": "base", "joints": rolls(NO_YAW["joints"])}
    found = read_model(urdf(robot, tmp_path), roles, typed).values
    assert found["geometry"]["sole"] == pytest.approx({"roll_height": 0.03, "width": 0.07})
    assert (found["virtual_knee"], found["links"]["upper_foot"]) == (None, None)
    assert_links(found, robot, "talus", "foot")
    assert found["joints"]["ankle_roll"]["upper"] == 0.4
    for name in ("hip_roll", "slide", "ankle_roll"):
        assert (found["drives"][name]["torque"], found["drives"][name]["speed"]) == (1.0, 1.0)


BOX = '<collision><geometry><box size="1 1 1"/></geometry></collision>'


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        (
            'name="left_ankle" (.*?)</joint>',
            r'name="left_ankle" \1<mimic joint="arm_joint"/></joint>',
            "found joint constraint of left_ankle and arm_joint",
        ),
        (
            'name="left_ankle_link"><inertial>.*?</inertial>',
            f'name="left_ankle_link">{BOX}',
            "masses of inertial elements in bodies, found left_ankle_link without",
        ),
    ],
    ids=["mimic", "without inertia"],
)
def test_a_urdf_is_one_whatever_its_file_is_called(before, after, message, tmp_path):
    path = urdf(lopsided(), tmp_path).rename(tmp_path / "robot.xml")
    substitute(path, before, after)
    change(path, "<robot", "<!-- <mujoco> --><robot")
    with pytest.raises(UserError, match=message):
        read_model(path, NO_YAW)


@pytest.mark.parametrize(
    ("before", "after", "remark", "mass"),
    [
        ('name="box"><inertial>.*?</inertial>', f'name="box">{BOX}', "no mass: box", -0.25),
        ('(name="box".*?)ixx="', r'\1ixx="-', "inertia, so a point mass: box", 0.0),
        ('name="arm"><inertial>.*?</inertial>', 'name="arm">', "", -0.25),
        ('(name="arm".*?mass value=)"0.25"', r'\1"0"', "", -0.25),
    ],
)
def test_held_bodies_without_mass_or_with_an_impossible_inertia(
    before, after, remark, mass, tmp_path
):
    path = urdf(lopsided(), tmp_path)
    expected = read_model(path, NO_YAW).values["links"]["base"]["mass"] + mass
    substitute(path, before, after)
    found = read_model(path, NO_YAW)
    assert found.values["links"]["base"]["mass"] == pytest.approx(expected, abs=1e-6)
    assert remark in " ".join(found.remarks)


def test_the_base_may_have_its_frame_at_the_ground_or_look_elsewhere(tmp_path):
    path, expected = urdf(lopsided(), tmp_path), read_model(tmp_path / "robot.urdf", NO_YAW)
    root = '<joint name="root" type="fixed"><parent link="footprint"/><child link="base"/>'
    root += '<origin xyz="0 0 0.7" rpy="0 0 {}"/></joint><link name="footprint"/></robot>'
    text = path.read_text(encoding="utf-8")
    for turn, forward in ((0.0, "x"), (np.pi, "-x"), (np.pi / 2, "y"), (-np.pi / 2, "-y")):
        path.write_text(text.replace("</robot>", root.format(turn)), encoding="utf-8")
        found = read_model(path, NO_YAW | {"base": "footprint", "forward": forward})
        above = np.sum(list(expected.values["geometry"]["axes"].values())[1:4], axis=0)[2]
        remark = f"the base's origin is {0.7 + above:.3f} m above that of the model"
        assert remark in " ".join(found.remarks)
        given, own = flatten(found.values), flatten(expected.values)
        for name in ("links.tube.com", "links.base.mass", "geometry.leg_length"):
            np.testing.assert_allclose(given[name], own[name], atol=1e-6)
        assert given["links.base.com"][2] == pytest.approx(own["links.base.com"][2] - above, 1e-6)
    with pytest.raises(UserError, match="ankle at y = -"):
        read_model(path, NO_YAW | {"base": "footprint", "forward": "y"})


def test_hinges_on_one_body_leave_light_links_and_our_slide_grows_downwards(tmp_path):
    """As many MJCF files have them: one body for the hip."""
    slide = 'slide" type="slide" axis="0 0 1" range="-0.2 0.1"'
    bodies = [(text, "") for text in (ROLL, PITCH)] + [(6 * "</body>", 4 * "</body>")]
    rolling(tmp_path, *bodies, (f'slide" axis="0 1 0" {AT}', slide))
    joints = rolls(ROLES["joints"])
    found = read_model(tmp_path / XML, {"base": "base", "joints": joints})
    masses = [found.values["links"][name]["mass"] for name in ("yaw", "roll", "pitch")]
    assert masses == [0.001, 0.001, 1.2]
    assert found.differs[0] < 1e-9
    slide = found.values["joints"]["slide"]
    assert (slide["lower"], slide["upper"]) == (-0.1, 0.2)


def test_a_robot_on_slider_may_have_a_motor_per_joint(folder):
    drive = "{torque: 10.0, speed: 3.0, stall_ratio: 2.0, inertia: 0.0}"
    motors = f"{{slide: {drive}, ankle: {drive}}}"
    gains = "{slide: {kp: 5000.0, kd: 100.0}, ankle: {kp: 50.0, kd: 1.0}}"
    change(
        folder / "robot.yaml", TEXT, f"{TEXT}\ncapstan: null\ndrives: {motors}\ngains: {gains}\n"
    )
    robot = composed(f"robot={folder}").robot
    assert robot.leg_motors == ("hip_yaw", "hip_roll", "hip_pitch", "slide", "ankle")
    assert robot.drives["hip_roll"] == replace(SLIDER.drives["hip_roll"], inertia=0.0)
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
    robot = composed(f"robot={folder}/robot.yaml").robot
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
    said = capsys.readouterr().out
    assert "held: nothing" in said
    assert "differ by 0.0%" in said
    assert picture.read_bytes().startswith(b"\x89PNG")
    row = next(line for line in said.splitlines() if line.startswith("hip_roll") and "%" in line)
    model = build_spec(composed(f"robot={folder}/robot.yaml").robot, SimulationOptions())
    model = model.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    joint, leg = model.joint("left_hip_roll").id, model.body("left_hip_roll").id
    lever = [data.subtree_com[body][1] - data.xanchor[joint][1] for body in (1, leg)]
    total, own = model.body_subtreemass[1], model.body_subtreemass[leg]
    expected = 9.81 * (own * lever[1] - total * lever[0])  # weight above the left roll axis
    assert float(row.split()[4]) == pytest.approx(expected, abs=0.06)


def test_meshes_and_textures_that_are_not_there_are_not_read(folder):
    assets = '<asset><mesh name="m" file="m.stl"/><texture name="t" type="2d" file="t.png"/>'
    assets += '<material name="c" texture="t"/></asset><worldbody>'
    geom = '<joint name="left_slide"'
    change(folder / "robot.xml", "<worldbody>", assets)
    change(folder / "robot.xml", geom, f'<geom type="mesh" mesh="m" material="c"/>{geom}')
    com = model_of(folder / YAML).values["links"]["tube"]["com"]
    np.testing.assert_allclose(com, lopsided().links.tube.com, atol=1e-6)


def change(path: Path, before: str, after: str) -> None:
    substitute(path, re.escape(before), after.replace("\\", r"\\"))


def substitute(path: Path, pattern: str, text: str, count: int = 1) -> None:
    content, times = re.subn(pattern, text, path.read_text("utf-8"), count=count, flags=re.DOTALL)
    assert times
    path.write_text(content, encoding="utf-8")


TENDON = '<tendon><fixed name="t"><joint joint="left_slide" coef="1"/></fixed></tendon>'


def joined(constraint: str) -> tuple[str, str]:
    return "</mujoco>", f"{TENDON}<equality>{constraint}</equality></mujoco>"


def test_a_joint_without_a_range_needs_a_typed_one(folder):
    pattern = '(_hip_roll"[^>]*) range="[^"]*"([^>]*) limited="true"'
    substitute(folder / XML, pattern, r"\1\2", 0)
    message = "a joint with a range, or joints.hip_roll.lower and joints.hip_roll.upper"
    with pytest.raises(UserError, match=message):
        read(folder / YAML)
    change(folder / YAML, "name: mine", "name: mine\njoints: {hip_roll: {lower: -0.5, upper: 0.4}}")
    joint = composed(f"robot={folder}").robot.joints["hip_roll"]
    assert (joint.lower, joint.upper) == (-0.5, 0.4)


MOTOR = "<motor joint='left_hip_yaw' gear='2' ctrlrange='-4 4' ctrllimited='true'/>"
SERVO = "<position joint='left_hip_roll' kp='30' kv='2' gear='3' forcerange='-7 7'/>"


def test_motors_come_from_the_model_but_for_typed_values(folder):
    substitute(folder / XML, r"<(actuator|sensor)>.*?</\1>", "", 0)
    change(folder / XML, "</mujoco>", f"<actuator>{MOTOR}{SERVO}</actuator></mujoco>")
    change(folder / YAML, "name: mine", "name: mine\ngains: {hip_roll: {kp: 5.0}}")
    robot = composed(f"robot={folder}").robot
    yaw, roll = robot.drives["hip_yaw"], robot.drives["hip_roll"]
    assert (yaw.torque, yaw.inertia, roll.torque) == (8.0, 0.0, 21.0)
    assert yaw.speed == SLIDER.drives["hip_yaw"].speed
    assert robot.gains["hip_yaw"].kp == pytest.approx(8.0 / 0.5)
    assert (robot.gains["hip_roll"].kp, robot.gains["hip_roll"].kd) == (5.0, 18.0)
    sources = model_of(folder / YAML).motors
    assert sources["drives.hip_yaw.torque"] == "ctrlrange"
    assert sources["drives.hip_roll.torque"] == "forcerange"
    assert (sources["gains.hip_yaw.kp"], "gains.hip_roll.kp" in sources) == ("rule", False)


def test_a_slide_that_is_slightly_off_is_told(folder):
    pattern = '(_slide" type="slide"[^>]*)axis="[^"]*"'
    substitute(folder / XML, pattern, r'\1axis="0.0035 0 -1"', 0)
    remarks = model_of(folder / YAML).remarks
    assert remarks.count("left_slide counts as along z, 0.20° off") == 1
    substitute(folder / XML, pattern, r'\1axis="0.02 0 -1"', 0)
    with pytest.raises(UserError, match="slide: expected an axis along z"):
        read(folder / YAML)


def test_an_anchor_may_be_anywhere_on_its_axis(folder):
    expected = model_of(folder / YAML).values
    change(folder / XML, '"right_ankle" ', '"right_ankle" pos="0 0.07 0" ')
    assert model_of(folder / YAML).values == expected


@pytest.mark.parametrize(("product", "passes"), [(0.03, True), (0.08, False)])
def test_products_of_the_base_count_as_zero_and_are_told(product, passes, folder):
    full = f"0.03 0.02 0.03 {0.03 * product} 0 0"
    base = f'<inertial pos="0 0 0.05" mass="2.25" fullinertia="{full}"/>'
    substitute(folder / XML, '<inertial pos="0 0 0.05"[^>]*/>', base)
    if not passes:
        with pytest.raises(UserError, match=r"within 5% of its moments \(roles.tolerance\), found"):
            read(folder / YAML)
        change(folder / YAML, "roles: {", "roles: {tolerance: 0.1, ")
    model = model_of(folder / YAML)
    assert f"Ixy and Iyz, {product:.1%} of its largest moment" in " ".join(model.remarks)
    assert model.values["links"]["base"]["products"] == [0.0, 0.0, 0.0]


def test_what_no_leg_has_is_ignored_by_name(folder):
    change(folder / "robot.xml", *joined('<weld body1="base"/>'))
    model = model_of(folder / "robot.yaml")
    assert model.remarks == ["ignored, as no leg has them: weld constraint of base and world"]


YAML, XML = "robot.yaml", "robot.xml"
SWAPPED = TEXT.replace("left", "other").replace("right", "left").replace("other", "right")


@pytest.mark.parametrize(
    ("name", "before", "after", "message"),
    [
        (YAML, "model: robot.xml", "model: none.xml", "robot.model: expected a model file"),
        (YAML, "model: robot.xml", "model: ../robot.xml", "expected a file beside this one"),
        (YAML, "base: base", "base: world", "roles.base: expected the body of the base, found wo"),
        (YAML, "base: base", "base: pelvis", "roles.base: expected a body of the model. Invalid n"),
        (YAML, "left_slide", "left_knee", "expected a joint of the model. Invalid name"),
        pytest.param(YAML, TEXT, SWAPPED, "m (left and right are swapped, or the b", id="swapped"),
        (YAML, "hip_yaw: [", "hip: [", "joints: expected hip_yaw, hip_roll, hip_pitch, slide"),
        (YAML, "yaw: [left_hip_yaw,", "yaw: [left_hip_roll,", "expected each joint once"),
        (YAML, "base: base,", "base: base, sides: left,", "unknown configuration key"),
        (YAML, "joints: {", "pose: {left_hip_roll: 0.5}, joints: {", "a level sole and the ankle"),
        (
            YAML,
            "right_hip_yaw], hip_roll: [left_hip_roll, right_hip_roll]",
            "right_hip_roll], hip_roll: [left_hip_roll, right_hip_yaw]",
            "of both hips (hip_yaw, hip_roll, hip_pitch), found hip_roll, hip_yaw, hip_pitch",
        ),
        (
            YAML,
            "[left_hip_yaw, right_hip_yaw], hip_roll: [left_hip_roll, right_hip_roll]",
            "[left_hip_roll, right_hip_roll], hip_roll: [left_hip_yaw, right_hip_yaw]",
            "joints.hip_yaw: expected an axis within 60° of z, found left_hip_roll along",
        ),
        (XML, 'left_slide" type="slide"', 'left_slide" type="hinge"', "expected a joint that"),
        (
            XML,
            "<worldbody>",
            "<xacro:include/><worldbody>",
            "first run `xacro robot.xml > robot.urdf",
        ),
        (XML, "<worldbody>", '<include file="robot.xml"/><worldbody>', "robot.model: robot.xml: "),
        (XML, 'mass="0.97"', 'mass="nan"', "robot.model: "),
        (XML, 'mass="0.97"', 'mass="1.97"', "expected legs that are alike"),
        (XML, 'range="-0.785 0.785"', 'range="-0.785 0.5"', "right_hip_roll that differ by"),
        (XML, 'range="-0.785 0.785"', 'range="0.2 0.785"', "a range that holds roles.pose, in rad"),
        (XML, 'range="-0.785 0.785"', 'range="-45 45"', "from -45 to 45 and its pose 0"),
        (XML, *joined('<joint joint1="left_ankle" joint2="left_slide"/>'), "and left_slide"),
        (XML, *joined('<connect body1="left_foot" body2="base" anchor="0 0 0"/>'), "found conn"),
        (XML, *joined('<tendon tendon1="t"/>'), "found tendon constraint of t"),
        (XML, 'joint name="left_ankle"', 'joint name="left_ankle" stiffness="3"', "of left_ankle"),
        (XML, "</mujoco>", TENDON.replace('"t"', '"t" stiffness="3"') + "</mujoco>", "spring of t"),
        (XML, "<compiler ", '<compiler inertiafromgeom="true" ', "expected masses of inertial"),
    ],
)
def test_a_mistake_is_one_line(folder, name, before, after, message):
    change(folder / name, before, after)
    with pytest.raises(UserError, match=re.escape(message)) as error:
        read(folder / "robot.yaml")
    assert "\n" not in str(error.value)


EXAMPLES = CONF.parent / "docs/examples/robots"


def test_the_example_of_the_tutorial(tmp_path, capsys):
    """What it inherits is listed; a hip that is wrong by 0.0455 rad is turned."""
    folder = shutil.copytree(EXAMPLES / "bruce", tmp_path / "bruce")
    text = (folder / YAML).read_text()
    said = printed(folder, text, capsys).splitlines()
    assert said[0].startswith("BRUCE: 4.53 kg, base 0.450 m above the ground")
    (rest,) = (line for line in said if line.startswith("from the robot that it builds on: "))
    assert "contact.friction" in rest
    assert "torque" not in rest
    said = printed(folder, text.replace("hip_pitch: -0.3455", "hip_pitch: -0.3"), capsys)
    assert "solved pose: {left_hip_pitch: -0.3455, left_ankle: -0.3545" in said


@pytest.mark.parametrize("name", sorted(p.parent.name for p in EXAMPLES.glob("*/robot.yaml")))
def test_an_example_weighs_what_its_model_does(name):
    """Links that the machine lacks weigh 1 g."""
    folder = EXAMPLES / name
    spec = mujoco.MjSpec.from_file(str(next(folder.glob("robot.[ux]*"))))
    spec.compiler.fusestatic = False
    ours = build_spec(composed(f"robot={folder}").robot, SimulationOptions()).compile()
    assert ours.body_mass.sum() == pytest.approx(spec.compile().body_mass.sum(), rel=5e-4)
