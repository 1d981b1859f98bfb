"""The documented program without this package does what the package does."""

import ast
import importlib.util
import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slider.config.env import EstimatorConfig, SensorsConfig
from slider.control.export import write_files
from slider.control.policy import Policy, PolicyController
from slider.env.interface import AgentInterface
from slider.env.physics import BatchedPhysics
from slider.library.lookup import GaitTable
from slider.robot.mjcf import nominal_qpos
from tests.control import policies
from tests.control.policies import write_policy
from tests.env.synthetic import config, turning_library
from tests.env.test_observations import PAPER

EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "run_policy.py"
VELOCITY = np.array([0.3, 0.05, 0.4])  # turning, between the gaits of the library
COMPUTED = {  # by the program; a robot's own terms are left out of the policies here
    *PAPER,
    *("action_before_previous", "base_height", "filtered_velocity", "reference_velocity"),
    *("velocity_error", "phase"),
}
ONBOARD = config("experiment=test").env.onboard
STEPS, STARTED, STOPPED = 65, 5, 45  # the command is zero before and afterwards


def exported(folder: Path, *overrides: str, estimator: EstimatorConfig | None = None) -> Policy:
    write_policy(folder / "policy.pt", *overrides, only=COMPUTED)
    return write_files(folder / "policy.pt", {}, folder, estimator)


def load_example():
    spec = importlib.util.spec_from_file_location("run_policy", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("overrides", "turning"),
    [
        ((), False),
        ((), True),
        (("env=paper",), True),
        (("env.phase.mirror=false",), True),
        (("env.phase.halt.below=5.0", "env.phase.halt.above=5.0"), True),
        (("env.action.offset=nominal",), True),
        (("env.reference.acceleration=0",), False),
    ],
)
def test_it_acts_and_moves_like_the_package(tmp_path, monkeypatch, overrides, turning):
    if turning:
        table = GaitTable.from_library(turning_library())
        monkeypatch.setattr(policies, "gait_table", lambda: table)
    policy = exported(tmp_path, *overrides)
    physics = BatchedPhysics(policy.robot, policy.env.physics, 1)
    physics.reset(np.arange(1), nominal_qpos(policy.robot)[None], np.zeros((1, 18)))
    agent = AgentInterface(policy.robot, policy.env, 1, policy.times, policy.reference)
    controller = PolicyController(policy.network, agent)
    controller.reset(physics.read(), np.zeros((1, 3)))
    example = load_example()
    outside = example.Policy(tmp_path)
    robot = example.Simulation(tmp_path, outside.layout)
    data = robot.data
    actions, halted = [], []
    for step in range(STEPS):
        command = VELOCITY if STARTED <= step < STOPPED else np.zeros(3)
        controller.set_velocity(command[None])
        expected = controller.control(physics.read())
        targets = outside.targets(robot.state(), command)
        np.testing.assert_allclose(targets, expected[0], atol=1e-4, err_msg=f"step {step}")
        physics.step(expected)
        data.qacc_warmstart[:] = 0.0  # the package keeps no warm start from step to step
        robot.move(targets)
        actions.append(outside.action)
        halted.append(outside.halted)
        np.testing.assert_allclose(data.qpos, physics.qpos[0], atol=1e-6)
        torques = physics.read().motor_torques[0]
        np.testing.assert_allclose(data.actuator_force, torques, atol=1e-3)
        # A foot may touch down a step of the simulation sooner in one of the two: go on as one.
        data.qpos[:], data.qvel[:] = physics.qpos[0], physics.qvel[0]
    moved = agent.view(physics.read()).action_scale > 0
    assert np.std(actions, axis=0)[moved].min() > 1e-3, "the policy must do something"
    if policy.env.phase.halt.below > 0:
        assert halted[0]
        assert not any(halted[STARTED + 1 : STOPPED])
        assert halted[-1]
    if policy.env.phase.mirror:
        assert STEPS * policy.env.control_period > 2 * policy.times.step_time.max()


def test_it_estimates_the_state_like_the_package(tmp_path):
    onboard = replace(ONBOARD, sensors=SensorsConfig(*[0.0] * 17))
    policy = exported(tmp_path, estimator=onboard.estimator)
    physics = BatchedPhysics(policy.robot, policy.env.physics, 1, onboard=onboard)
    example = load_example()
    outside = example.Policy(tmp_path)
    robot = example.Simulation(tmp_path, outside.layout)
    estimator = example.Estimator(outside.layout, robot.model)
    physics.reset(np.arange(1), robot.data.qpos[None].copy(), np.zeros((1, 18)))
    for _ in range(STEPS):
        expected, state = physics.measure(physics.read()), estimator.update(robot.measure())
        for name in ("linear_velocity", "heading_velocity", "gravity", "yaw"):
            np.testing.assert_allclose(state[name], getattr(expected, name)[0], atol=1e-6)
        assert state["height"] == pytest.approx(expected.base_height[0], abs=1e-6)
        targets = outside.targets(state, VELOCITY)
        robot.data.qacc_warmstart[:] = 0.0
        robot.move(targets)
        physics.step(targets[None])
    assert abs(expected.heading_velocity[0, 0]) > 0.01, "the robot must move"


def test_it_computes_its_terms_and_names_one_that_it_cannot(tmp_path):
    exported(tmp_path)
    example = load_example()
    outside = example.Policy(tmp_path)
    state = example.Simulation(tmp_path, outside.layout).state()
    outside.heading_target = 0.0
    assert outside.terms(state, VELOCITY).keys() >= COMPUTED
    outside.layout["observation"]["terms"][3] |= {"name": "smell", "meaning": "how it smells"}
    with pytest.raises(SystemExit, match="expected a value of smell here: how it smells"):
        outside.targets(state, VELOCITY)


def test_it_is_a_program_of_python_3_8():
    """Grammar, and annotations that are not evaluated."""
    tree = ast.parse(EXAMPLE.read_text(), feature_version=(3, 8))
    assert "__future__" in [x.module for x in tree.body if isinstance(x, ast.ImportFrom)]
    called = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    keywords = {node.arg for node in ast.walk(tree) if isinstance(node, ast.keyword)}
    assert not (called | keywords) & {"removeprefix", "removesuffix", "pairwise", "strict"}


def test_a_model_that_mujoco_cannot_read_names_the_version_that_can(tmp_path):
    exported(tmp_path)
    model = tmp_path / "robot.xml"
    model.write_text(model.read_text().replace('gaintype="dcmotor"', 'gaintype="future"'))
    layout = json.loads((tmp_path / "policy.json").read_text())
    oldest = layout["simulation"]["mujoco"]
    with pytest.raises(SystemExit, match=rf"^robot.xml: expected MuJoCo {oldest} or newer, found"):
        load_example().Simulation(tmp_path, layout)


def test_it_runs_as_a_program_without_the_package(tmp_path):
    exported(tmp_path, estimator=ONBOARD.estimator)
    blocked = tmp_path / "blocked" / "slider"
    blocked.mkdir(parents=True)
    (blocked / "__init__.py").write_text("raise ImportError('the example needs the package')")
    options = ["--velocity", "0", "0", "0", "--seconds", "1", "--onboard"]
    answer = subprocess.run(
        [sys.executable, str(EXAMPLE), str(tmp_path), *options],
        env={"PYTHONPATH": str(blocked.parent)},
        capture_output=True,
        text=True,
        check=False,
    )
    if answer.returncode == 0:
        first, last = answer.stdout.splitlines()
        assert first.startswith("estimator: ")
        assert last.startswith("walked: 1.0 s")
    else:  # the network is not trained
        assert re.fullmatch(r"fell after 0\.\d\d s\n", answer.stderr)


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ("--velocity nan 0 0", "argument --velocity: invalid number value: 'nan'"),
        ("--seconds -1", "argument --seconds: invalid duration value: '-1'"),
        ("--seconds inf", "argument --seconds: invalid duration value: 'inf'"),
    ],
)
def test_an_impossible_option_is_one_line(options, line, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["run_policy.py", "nowhere", *options.split()])
    with pytest.raises(SystemExit, match="2"):
        load_example().main()
    assert capsys.readouterr().err.splitlines()[-1].endswith(line)


@pytest.mark.parametrize("fall", ["tilted", "low", "reset by MuJoCo"])
def test_a_fall_ends_it_with_status_1(fall, monkeypatch, tmp_path):
    exported(tmp_path)
    example = load_example()
    move = example.Simulation.move

    def fall_once(robot, targets) -> None:
        data = robot.data
        assert not robot.has_fallen()
        move(robot, targets)
        if data.time > 0.1:
            if fall == "tilted":
                data.qpos[3:7] = np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0
            elif fall == "low":
                data.qpos[2] *= 0.4
            else:  # it begins anew, upright
                data.qvel[3] = 1e12
                move(robot, targets)
                data.qpos[2] = robot.layout["observation"]["nominal_height"]

    monkeypatch.setattr(sys, "argv", ["run_policy.py", str(tmp_path), "--seconds", "1"])
    monkeypatch.setattr(example.Simulation, "move", fall_once)
    with pytest.raises(SystemExit, match=r"^fell after 0\.1\d s$"):
        example.main()
