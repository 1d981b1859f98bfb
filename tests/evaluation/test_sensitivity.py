"""A policy on another robot: the plant is the other one's, what the policy believes stays."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from slider.config.convert import to_dict
from slider.config.parameters import scaled
from slider.control.policy_file import Policy, PolicyNetwork, save_policy
from slider.core.job import Job
from slider.evaluation import protocol, stage
from slider.evaluation.protocol import read_protocol
from slider.evaluation.results import ROBOTS, Evaluation
from slider.evaluation.stage import folder_name, run_changed, simulate
from slider.robot.mjcf import nominal_qpos
from tests.env.synthetic import config, gait_table, make_agent

COMMANDS = [0.2, 0.4]
WHOLE = config("experiment=test")
LONG = scaled(WHOLE.robot, "geometry.leg_length", 1.05)


def section(robot=WHOLE.robot, **changes) -> dict:
    evaluation = replace(WHOLE.evaluation, trials=1, robots=3, duration=0.4, **changes)
    return {
        "robot": to_dict(robot),
        "env": to_dict(WHOLE.env),
        "evaluation": to_dict(evaluation),
        "controller": "policy",
        "commands": COMMANDS,
    }


@pytest.fixture(scope="module")
def walking(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("walking")
    layout = make_agent(1).observer.layout
    torch.manual_seed(0)
    network = PolicyNetwork(sum(layout.values()), 12, (16,), "elu")
    table, facts = gait_table(), {"seed": 1}
    policy = Policy(
        network.eval(),
        (16,),
        "elu",
        layout,
        table.times,
        WHOLE.robot,
        WHOLE.env,
        facts,
        table.joints,
    )
    save_policy(policy, folder / "policy.pt")
    return folder


def run_in(folder: Path, walking: Path, robot=WHOLE.robot) -> dict:
    folder.mkdir()
    return run_changed(section(robot), {"walking": [walking]}, folder, Job(folder))


def on(robot, walking: Path):
    """The policy on some robots of a kind."""
    values = section(robot) | {"command": 0.2}
    test = read_protocol(values)
    inputs = {"walking": [walking]}
    return simulate(values, inputs, test.count, test.disturbance, changed=True)


def test_records_of_each_command_have_a_folder(walking, tmp_path):
    summary = run_in(tmp_path / "out", walking)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"0.2", "0.4"}
    for command, success in zip(COMMANDS, summary["success_rate"], strict=True):
        robots = Evaluation.load(tmp_path / "out" / folder_name(command)).robots
        assert len(robots.survived) == 3
        assert success == robots.survived.mean()


def test_on_its_own_robot_it_is_the_evaluation(walking, tmp_path):
    run_in(tmp_path / "out", walking)
    (tmp_path / "evaluation").mkdir()
    for command in COMMANDS:
        own = section() | {"command": command}
        stage.run(own, {"walking": [walking]}, tmp_path / "evaluation", Job(tmp_path))
        expected = (tmp_path / "evaluation" / ROBOTS).read_bytes()
        assert (tmp_path / "out" / folder_name(command) / ROBOTS).read_bytes() == expected


def test_the_plant_is_the_changed_robot_and_the_agent_keeps_its_own(walking):
    """A longer leg: the robot stands higher, the policy's nominal height stays."""
    simulated = on(LONG, walking)
    own, other = nominal_qpos(WHOLE.robot)[2], nominal_qpos(LONG)[2]
    assert other == pytest.approx(own + 0.05 * WHOLE.robot.geometry.leg_length)
    assert simulated.physics.nominal[2] == other
    assert simulated.physics.robot == LONG
    agent = simulated.controller.agent
    assert agent.nominal_height == own
    np.testing.assert_array_equal(agent.nominal, nominal_qpos(WHOLE.robot)[7:])


def test_narrower_joints_of_the_plant_do_not_narrow_the_targets(walking):
    """The policy commands what it did on its own robot; the plant's own stops hold the joint."""
    paths = [
        path
        for path, value in _joint_ranges(to_dict(WHOLE.robot))
        if path.endswith("hip_pitch.upper") and value > 0
    ]
    assert paths
    narrow = scaled(WHOLE.robot, paths[0], 0.01)
    targets = []
    for robot in (WHOLE.robot, narrow):
        agent = on(robot, walking).controller.agent
        targets.append(agent.act(np.full((3, 12), 5.0)))
    np.testing.assert_array_equal(*targets)


def _joint_ranges(node: dict, prefix: str = "") -> list[tuple[str, float]]:
    found = []
    for name, value in node.items():
        if isinstance(value, dict):
            found += _joint_ranges(value, f"{prefix}{name}.")
        elif isinstance(value, float):
            found.append((f"{prefix}{name}", value))
    return found


def test_starts_are_those_of_the_changed_robot(walking, tmp_path, monkeypatch):
    seen = []
    real = protocol.roll_out

    def spying(controller, physics, env, start, *rest):
        seen.append(start[0])
        return real(controller, physics, env, start, *rest)

    monkeypatch.setattr(protocol, "roll_out", spying)
    run_in(tmp_path / "own", walking)
    run_in(tmp_path / "long", walking, LONG)
    own, other = seen[0], seen[2]
    np.testing.assert_allclose(own[:, 3:], other[:, 3:])  # the same noise
    assert (other[:, 2] - own[:, 2]).min() > 0.02
