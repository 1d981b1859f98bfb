"""Robot and environment of a scene, replays along their course, agents that can be steered."""

import argparse
from dataclasses import replace

import numpy as np
import pytest

from slider.artefacts.run_metadata import note_start
from slider.commands.play import add_arguments, choose
from slider.config.env import TerminationConfig
from slider.core.errors import UserError
from slider.library.reader import STORE, GaitLibrary
from slider.play import scenes
from slider.play.scenes import Replay
from tests.config.composed import CONF, composed
from tests.control.policies import write_policy
from tests.library.gaits import straight

SAMPLES = 10


def scene(*arguments: str) -> scenes.Scene:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return choose(parser.parse_args([*arguments, "--conf", str(CONF)]))


@pytest.mark.parametrize("override", ["env=paper", "robot.gains.capstan.kp=2.8"])
def test_a_policy_walks_where_it_was_trained(tmp_path, override):
    policy = write_policy(tmp_path / "policy.pt", override)
    played = scene("--policy", str(tmp_path / "policy.pt"), "--set", "evaluation=robust")
    assert played.robot == policy.robot
    assert not played.motion.start(np.zeros(3)).failed


def test_overrides_of_the_environment_are_obeyed(tmp_path):
    write_policy(tmp_path / "policy.pt")
    with pytest.raises(UserError, match=r"^policy: expected env\.\w.*, as in its training, found "):
        scene("--policy", str(tmp_path / "policy.pt"), "--set", "env=paper")


def test_an_override_of_the_plant_leaves_the_policys_interface(tmp_path, monkeypatch):
    policy = write_policy(tmp_path / "policy.pt", "env.reference.acceleration=1.0")
    environments = []
    monkeypatch.setattr(scenes, "Episode", lambda *parts: environments.append(parts[2]))
    override = "env.termination.terms.base_height=0.3"
    scene("--policy", str(tmp_path / "policy.pt"), "--set", override)
    terms = {**policy.env.termination.terms, "base_height": 0.3}
    assert environments == [replace(policy.env, termination=TerminationConfig(terms))]


@pytest.mark.parametrize(
    ("arguments", "name"), [([], "mine"), (["--set", "robot=slider"], "slider")]
)
def test_the_robot_is_that_of_the_last_pipeline_run(arguments, name, tmp_path):
    plans = tmp_path / "plans"
    plans.mkdir()
    note_start(plans / "a.json", [f"robot={tmp_path}/a robot.yaml", "robot.links.base.mass=3.0"])
    (tmp_path / "a robot.yaml").write_text("defaults: [slider, _self_]\nname: mine\n")
    robot = scene("zero", "--artefacts", str(tmp_path), *arguments).robot
    assert (robot.name, robot.links.base.mass) == (name, 3.0 if name == "mine" else 2.25)


def test_gaits_of_another_robot_are_refused():
    path = straight() / STORE
    other = f"robot={CONF.parent}/docs/examples/robots/bruce"
    with pytest.raises(UserError, match=r"expected gaits of the robot BRUCE .*, found those of"):
        scenes.gait_scene(path, [0.4, 0.0, 0.0], composed(other))
    assert scenes.gait_scene(path, [0.4, 0.0, 0.0], composed()).robot == composed().robot


def library(*velocities: tuple[float, float, float]) -> GaitLibrary:
    """Gaits of constant speed and yaw rate on their arcs: joint 0 is the time within the walk."""
    half, count = SAMPLES // 2, len(velocities)
    time = np.concatenate([np.linspace(0.0, 0.3, half), 0.3 + np.linspace(0.0, 0.5, half)])
    samples, base = np.zeros((count, SAMPLES, 26)), np.zeros((count, SAMPLES, 13))
    samples[..., 0], base[..., 2] = time, 0.7
    for row, (vx, vy, rate) in zip(base, velocities, strict=True):
        angle = rate * time / 2
        place = (vx + 1j * vy) * time * np.exp(1j * angle) * np.sinc(angle / np.pi)
        row[:, 0], row[:, 1] = place.real, place.imag
        row[:, 3], row[:, 6] = np.cos(angle), np.sin(angle)
    arrays = {"samples": samples, "base": base, "step_time": np.tile([0.3, 0.5], (count, 1))}
    return GaitLibrary({**arrays, "velocities": np.array(velocities)}, {})


def test_replay_takes_the_nearest_gait_and_goes_on_for_ever():
    gaits = library((0.2, 0.0, 0.0), (0.6, 0.1, 0.0))
    gaits.arrays["step_time"][0] = 0.4
    motion = Replay(gaits, (0.7, 0.05, 0.0), period=0.02)
    frames = [motion.start(np.zeros(3))] + [motion.step(np.zeros(3)) for _ in range(100)]
    np.testing.assert_allclose(motion.velocity, [0.6, 0.1, 0.0])
    last = frames[-1]
    assert last.time == pytest.approx(2.0)
    np.testing.assert_allclose(last.qpos[:3], [1.2, 0.2, 0.7], atol=1e-9)
    assert last.qpos[7] == pytest.approx(2.0 - 2 * 0.8)  # two walks of 0.8 s are over


def test_a_turning_gait_goes_along_its_arc():
    """The base is on a circle, its heading tangential to it."""
    speed, rate = 0.6, 0.3
    motion = Replay(library((speed, 0.0, rate)), (0.5, 0.0, 0.2), period=0.02)
    frames = [motion.start(np.zeros(3))] + [motion.step(np.zeros(3)) for _ in range(300)]
    angle = rate * np.array([frame.time for frame in frames])
    place = np.array([frame.qpos for frame in frames])
    circle = speed / rate * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
    np.testing.assert_allclose(place[:, :2], circle, atol=5e-4)  # linear between samples
    np.testing.assert_allclose(place[:, 6], np.sin(angle / 2), atol=1e-5)


def mean_velocity(motion: scenes.Motion, velocity, seconds: float) -> np.ndarray:
    frames = [motion.step(np.array(velocity)) for _ in range(round(seconds / motion.period))]
    assert not frames[-1].failed
    return np.mean([frame.velocity for frame in frames[len(frames) // 2 :]], axis=0)


def test_a_controller_follows_a_velocity_that_changes():
    motion = scene("mpc_wbc_tuned").motion
    motion.start(np.array([0.2, 0.0, 0.0]))
    assert mean_velocity(motion, [0.2, 0.0, 0.0], 3.0)[0] == pytest.approx(0.2, abs=0.08)
    assert mean_velocity(motion, [0.6, 0.0, 0.0], 4.0)[0] == pytest.approx(0.6, abs=0.08)


@pytest.mark.parametrize(
    "folder", sorted((CONF.parent / "docs").glob("policy*")), ids=lambda p: p.name
)
def test_a_policy_that_ships_walks_on_the_robot_of_today(folder):
    motion = scene("--policy", str(folder), "--set", "robot=slider").motion
    motion.start(np.zeros(3))
    assert mean_velocity(motion, [0.6, 0.0, 0.0], 4.0)[0] == pytest.approx(0.6, abs=0.06)


@pytest.mark.parametrize("agent", ["zero", "mpc_wbc_tuned"])
def test_a_push_changes_the_velocity_of_the_base(agent):
    def velocity(push):
        motion = scene(agent, "--seed", "3").motion
        motion.start(np.zeros(3))
        motion.push(np.array(push))
        return motion.step(np.zeros(3)).velocity

    assert velocity([0.0, 0.4])[1] - velocity([0.0, 0.0])[1] > 0.2


@pytest.mark.parametrize("agent", ["zero", "random"])
def test_smoke_agents_start_upright_and_repeat_themselves(agent):
    def run():
        motion = scene(agent, "--seed", "3").motion
        frames = [motion.start(np.zeros(3))] + [motion.step(np.zeros(3)) for _ in range(5)]
        return np.array([frame.qpos for frame in frames])

    first = run()
    assert 0.6 < first[0, 2] < 0.8
    np.testing.assert_array_equal(first, run())
