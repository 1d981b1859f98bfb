"""A robot from a file outside ``conf/``: its values, tags, recipes and mistakes."""

import sys

import pytest
from omegaconf import OmegaConf

from pipeline.stages import table1_jobs
from pipeline.stages.gaits import library_job
from slider.config.convert import from_dict
from slider.config.parameters import parameters
from slider.config.robot import SOLE_LINKS
from slider.robot.mjcf import SimulationOptions, build_spec
from slider.robot.model_tree import Roles
from tests.config.composed import CONF, composed, refusal
from tests.robot.lopsided import kneed

SLIDER = (CONF / "robot" / "slider.yaml").read_text(encoding="utf-8")
CHANGED = """
defaults: [slider, _self_]
name: mine
geometry: {ankle_height: 0.05}
links:
  base: {mass: 3.0, com: [0.0, 0.0, 0.06]}
provenance: {geometry: measured, links.base.com: measured}
"""


@pytest.fixture
def written(tmp_path):
    def write(text: str, name: str = "my robot.yaml") -> str:
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return f"robot={path}"

    return write


def test_a_value_of_the_file_has_the_file_s_tag_or_none(written):
    robot = composed(written(CHANGED), "robot.links.base.mass=4.0").robot
    tags = {item.path: item.provenance for item in parameters(robot)}
    before = {item.path: item.provenance for item in parameters(composed().robot)}
    changed = {path: tag for path, tag in tags.items() if tag != before[path]}
    assert robot.name == "mine"
    assert (robot.geometry.ankle_height, robot.links.base.mass) == (0.05, 4.0)
    assert changed.pop("links.base.mass") == ""  # it was assumed
    assert changed.pop("links.base.com") == "measured"
    assert changed.pop("geometry.ankle_height") == "measured"  # SLIDER's longer path had earlier
    assert {path.partition(".")[0] for path in changed} == {"geometry"}
    assert tags["geometry.leg_length"] == "earlier"


def test_tags_are_optional(written):
    text = SLIDER.partition("provenance:")[0]
    robot = composed(written(text)).robot
    assert {item.provenance for item in parameters(robot)} == {""}


def test_recipes_follow_the_values_and_not_the_place(written):
    def recipes(text: str, name: str) -> tuple[str, str]:
        config = composed("experiment=test", written(text, name))
        return library_job(config).recipe, table1_jobs(config)["table1"].recipe

    plain = composed("experiment=test")
    same = library_job(plain).recipe, table1_jobs(plain)["table1"].recipe
    assert recipes(SLIDER, "a.yaml") == recipes(SLIDER, "folder/b.yml") == same
    gains = recipes(SLIDER.replace("kp: 80.0", "kp: 81.0"), "a.yaml")
    assert gains[0] == same[0]  # gaits do not know the drives' gains
    assert gains[1] != same[1]
    assert recipes(SLIDER.replace("mass: 2.25", "mass: 2.5"), "a.yaml")[0] != same[0]


BASE = "defaults: [slider, _self_]\nname: mine\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name: [\n", "line 2: expected YAML, found an error"),
        ("- a\n", "expected keys and values, found list"),
        ("name: mine\n", "robot.geometry: expected a value, found none"),
        (BASE.replace("slider", "nope"), "expected [slider, _self_], found ['nope', '_self_']"),
        (BASE + "provenance: {links: cad}", "expected 'measured', 'paper', 'earlier' or 'assumed'"),
        (BASE + "links: {base: {com: [0, 0.01, 0]}}", "links.base: expected y, Ixy and Iyz of 0"),
    ],
)
def test_a_mistake_is_one_line(written, text, message):
    assert message in refusal([written(text)])


def test_no_such_file(tmp_path):
    assert "expected a YAML file, found: No such file" in refusal([f"robot={tmp_path}/none.yaml"])


def test_an_installed_package_names_its_robot(written, tmp_path, monkeypatch):
    written(CHANGED, "robot.yaml")
    (tmp_path / "their_robots.py").write_text(
        "from pathlib import Path\nHERE = Path(__file__).parent\n"
    )
    info = tmp_path / "theirs-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Name: theirs\nVersion: 1.0\n")
    names = "theirs = their_robots:HERE\nslider = their_robots:HERE\nlost = their_robots:NOPE\n"
    (info / "entry_points.txt").write_text(f"[slider.robots]\n{names}")
    monkeypatch.syspath_prepend(tmp_path)
    assert composed("robot=theirs").robot.name == "mine"
    assert composed("robot=slider").robot.name == "slider"
    assert "no attribute 'NOPE'" in (lost := refusal(["robot=lost"]))
    assert lost.startswith("robot=lost: expected one package ")
    assert "unknown option robot=their, expected one of: " in refusal(["robot=their"])


def test_the_virtual_knee_s_tube_has_its_centre_on_its_axis():
    off = "robot.links.tube.com=[0.01,0.0,-0.2]"
    assert composed(off).robot.links.tube.com[0] == 0.01
    assert "expected com x and y, and products" in refusal([off, "gait.dynamics=knee"])


def test_defaults_follow_the_robot_and_typed_numbers_stay(written):
    small = "geometry: {leg_length: 0.32, axes: {hip_yaw: [0, 0.05, 0]}, upper_foot_height: 0.18}\n"
    knee = "virtual_knee: {thigh_length: 0.18, shank_length: 0.18}\n"
    file = written(BASE + small + knee + "links: {base: {mass: 14.7748}}\n")  # 12.5248 kg more
    config = composed(file, "gait.posture.swing_height=0.1")
    posture, mpc = config.gait.posture, config.control["mpc_wbc_tuned"]
    assert config.env.termination.terms["base_height"] == pytest.approx(0.2)
    assert (posture.clearance, posture.swing_height) == (pytest.approx(0.025), 0.1)
    assert posture.foot_separation_max == pytest.approx(0.225)
    assert (mpc.step.width, mpc.planner.width_max) == pytest.approx((0.10495, 0.2))
    root, times = 0.5**0.5, config.gait.step_time
    assert (times.lower, times.upper) == pytest.approx((0.25 * root, 0.32 * root))
    assert config.gait.touchdown.forward == pytest.approx(0.3 * root)
    assert posture.torso_rate == pytest.approx(1.0 / root)
    assert mpc.whole_body.force_max == pytest.approx(1200.0)
    height = config.train.walking.reward.terms["guide_height"]
    assert height.params["width"] == pytest.approx(0.0025 / 4)
    found = refusal([file, "env.termination.terms.base_height=0.4"])
    assert found.endswith("less than 0.365 m, at which the robot stands, found 0.4")
    found = refusal(["robot.geometry.leg_length=long"])
    assert found.startswith("robot.geometry.leg_length: expected a valid number, ")


SHIPPED = sorted((CONF.parent / "src/slider/composition/menagerie").glob("*.yaml"))


@pytest.fixture
def described(tmp_path, monkeypatch):
    """A package ``robot_descriptions`` whose module for H1 does what a text says."""

    def write(text: str) -> None:
        folder = tmp_path / "robot_descriptions"
        folder.mkdir()
        (folder / "__init__.py").touch()
        (folder / "h1_mj_description.py").write_text(text)
        monkeypatch.syspath_prepend(tmp_path)

    yield write
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        del sys.modules[name]


def test_a_robot_of_the_menagerie_by_name(described, tmp_path, capsys):
    spec = build_spec(kneed(), SimulationOptions())
    spec.compile()
    text = spec.to_xml().replace("_slide", "_knee").replace('"base"', '"pelvis"')
    path = tmp_path / "h1.xml"
    path.write_text(text, encoding="utf-8")
    described(f"print('Cloning')\nMJCF_PATH = {str(path)!r}\n")
    robot = composed("robot=menagerie:h1", "robot.drives.ankle.torque=41").robot
    assert (robot.name, robot.drives["ankle"].torque) == ("Unitree H1", 41.0)
    assert abs(robot.geometry.bend) == pytest.approx(abs(kneed().geometry.bend))
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("name", "module", "message"),
    [
        ("h1", "raise RuntimeError('Could not\\nresolve host')", "clone, found: Could not resolve"),
        ("g1", "", "menagerie:g1: expected a model that robot_descriptions (pip install -e"),
        ("unitree_h1", "", "menagerie:unitree_h1: expected adam_lite or booster_t1 or g1 or h1 or"),
    ],
)
def test_a_robot_that_the_menagerie_cannot_give_is_one_line(described, name, module, message):
    described(module)
    assert message in refusal([f"robot=menagerie:{name}"])


@pytest.mark.parametrize("path", SHIPPED, ids=[path.stem for path in SHIPPED])
def test_roles_that_we_ship_have_all_that_is_asked_for(path):
    node = OmegaConf.to_container(OmegaConf.load(path))
    roles = from_dict(Roles, node["roles"], "roles")
    last = "ankle_roll" if path.stem not in ("h1", "n1", "talos") else "upper_foot"
    driven = {*SOLE_LINKS} - {"upper_foot", *["ankle_roll"] * (last == "upper_foot")}
    assert {*roles.joints} == driven - {"slide"} | {"knee", last}
    assert {*node["drives"]} == {*node["gains"]} == driven
    assert node["name"]
