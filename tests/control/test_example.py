"""The documented program walks the shipped policy, without this package, and survives a robot."""

import ast
import importlib.util
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

from slider.control.exported import load_exported
from slider.env.physics import BatchedPhysics
from slider.env.rollout import roll_out
from slider.env.starts import USUAL_NOISE, at_rest
from tests.config.composed import composed

DOCS = Path(__file__).parents[2] / "docs"
EXAMPLE, SHIPPED = DOCS / "examples" / "run_policy.py", DOCS / "policy"
PERIOD = 0.02


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("run_policy", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def contract() -> dict:
    return json.loads((SHIPPED / "policy.json").read_text())


def test_the_shipped_policy_is_of_this_version_and_walks():
    """Otherwise: ``make policy``."""
    config = composed()
    policy = load_exported(SHIPPED, config.robot, config.env)
    terms = json.loads((SHIPPED / "policy.json").read_text())["observation"]
    assert {term["name"]: term["scale"] for term in terms} == config.env.observation.terms
    speeds = np.array([0.4, 1.2, 2.2])
    physics = BatchedPhysics(config.robot, config.env.physics, 3)
    start = at_rest(config.robot, USUAL_NOISE, np.random.default_rng(0), 3)
    command = speeds[:, None] * [1.0, 0.0, 0.0]
    recording = roll_out(policy, physics, config.env, start, command, 5.0)
    assert recording.survived.all()
    np.testing.assert_allclose(recording.velocity[100:, :, 0].mean(axis=0), speeds, atol=0.15)


class Walk:
    """The shipped policy in plain MuJoCo."""

    def __init__(self, example, contract, folder: Path = SHIPPED) -> None:
        self.policy = example.Graph(folder, "policy.onnx", contract)
        self.robot = example.Simulation(folder, contract)

    def go(self, seconds: float, speed: float) -> float:
        """Distance [m]; the robot must not fall."""
        start = self.robot.data.qpos[0]
        for tick in range(round(seconds / PERIOD)):
            readings = self.robot.measure() | {"command": np.array([speed, 0.0, 0.0])}
            self.robot.move(*self.policy(self.robot.data.time, readings))
            assert not self.robot.has_fallen(), f"tick {tick}"
        return self.robot.data.qpos[0] - start


def test_a_restart_is_a_new_object(example, contract):
    walk, fresh = Walk(example, contract), Walk(example, contract)
    walk.go(1.0, 1.2)
    readings = fresh.robot.measure() | {"command": np.array([1.2, 0.0, 0.0])}
    expected = fresh.policy(0.0, readings)
    for now in (5.0, 0.0):  # a pause; a time that went back
        np.testing.assert_array_equal(walk.policy(now, readings), expected)


def test_missed_and_late_ticks_are_made_up_for(example, contract):
    """Calls at any times within a period of the due ones: the clock is that of the time."""
    regular, irregular = (Walk(example, contract).policy for _ in range(2))
    readings = Walk(example, contract).robot.measure() | {"command": np.array([1.2, 0.0, 0.0])}
    for tick in range(100):
        expected = regular(PERIOD * tick, readings)
        if tick % 7 != 3:  # missed, but the first and last
            found = irregular(PERIOD * (tick + 0.4 * (tick % 2)), readings)
            np.testing.assert_allclose(found, expected, atol=1e-12)
    np.testing.assert_array_equal(irregular(PERIOD * 99.4, readings), found)  # the same period


def test_joints_are_found_by_name_and_the_rate_of_the_network_is_the_contracts(
    example, contract, tmp_path
):
    """The model's legs change places, and with them its joints and motors; its time step, too."""
    folder = shutil.copytree(SHIPPED, tmp_path / "policy")
    tree = ElementTree.parse(folder / "robot.xml")
    base = next(body for body in tree.iter("body") if body.get("name") == "base")
    legs = base.findall("body")
    base.remove(legs[0])
    base.append(legs[0])
    motors = tree.getroot().find("actuator")
    motors[:] = motors[::-1]
    tree.getroot().find("option").set("timestep", "0.004")
    tree.write(folder / "robot.xml")
    model = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    assert model.joint(1).name != contract["joints"][0]["name"]
    assert Walk(example, contract, folder).go(3.0, 1.2) == pytest.approx(2.8, abs=0.7)
    tree.getroot().find("option").set("timestep", "0.003")
    tree.write(folder / "robot.xml")
    with pytest.raises(SystemExit, match=r"divides the control period of 0.02 s, found 0.003$"):
        example.Simulation(folder, contract)


def test_it_is_a_short_program_of_python_3_8():
    """Grammar, and annotations that are not evaluated."""
    text = EXAMPLE.read_text()
    assert len(text.splitlines()) <= 150
    tree = ast.parse(text, feature_version=(3, 8))
    assert "__future__" in [x.module for x in tree.body if isinstance(x, ast.ImportFrom)]
    called = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    keywords = {node.arg for node in ast.walk(tree) if isinstance(node, ast.keyword)}
    assert not (called | keywords) & {"removeprefix", "removesuffix", "pairwise", "strict"}


def test_a_model_that_mujoco_cannot_read_names_the_version_that_can(example, contract, tmp_path):
    folder = shutil.copytree(SHIPPED, tmp_path / "policy")
    model = folder / "robot.xml"
    model.write_text(model.read_text().replace('gaintype="dcmotor"', 'gaintype="future"'))
    oldest = contract["simulation"]["mujoco"]
    with pytest.raises(SystemExit, match=rf"^robot.xml: expected MuJoCo {oldest} or newer, found"):
        example.Simulation(folder, contract)


def test_it_walks_on_its_sensors_as_a_program_without_the_package(tmp_path):
    blocked = tmp_path / "blocked" / "slider"
    blocked.mkdir(parents=True)
    (blocked / "__init__.py").write_text("raise ImportError('the example needs the package')")
    answer = subprocess.run(
        [sys.executable, str(EXAMPLE), str(SHIPPED), "--velocity", "1.2", "0", "0", "--onboard"],
        env={"PYTHONPATH": str(blocked.parent)},
        capture_output=True,
        text=True,
        check=True,
    )
    first, last = answer.stdout.splitlines()
    errors = re.fullmatch(r"estimator: error of vx, vy: (.*), (.*) m/s RMS", first)
    assert max(map(float, errors.groups())) < 0.05
    assert float(re.match(r"walked: 10.0 s, x = (\S+) m", last)[1]) == pytest.approx(11.5, abs=1.0)


@pytest.mark.parametrize("fall", ["tilted", "low", "reset by MuJoCo"])
def test_a_fall_ends_it_with_status_1(example, fall, monkeypatch):
    move = example.Simulation.move

    def fall_once(robot, targets) -> None:
        data = robot.data
        assert not robot.has_fallen()
        move(robot, targets)
        if data.time > 0.1:
            if fall == "tilted":
                data.qpos[3:7] = np.sqrt([0.5, 0.0, 0.5, 0.0])
            elif fall == "low":
                data.qpos[2] *= 0.4
            else:  # it begins anew, upright
                data.qvel[3] = 1e12
                move(robot, targets)
                data.qpos[2] = robot.height

    monkeypatch.setattr(sys, "argv", ["run_policy.py", str(SHIPPED), "--seconds", "1"])
    monkeypatch.setattr(example.Simulation, "move", fall_once)
    with pytest.raises(SystemExit, match=r"^fell after 0\.\d\d s$"):
        example.main()
