"""Replays, agents that know nothing, and the loop around them."""

from pathlib import Path

import numpy as np
import pytest

from slider.cli import main
from slider.config.compose import compose
from slider.env.rollout import Frame
from slider.library.reader import GaitLibrary
from slider.play import loop
from slider.play.loop import Control
from slider.play.motion import Replay, simulate_agent

CONF = Path(__file__).parents[2] / "conf"
SAMPLES = 10


def library() -> GaitLibrary:
    """Two gaits that move straight on: base x = vx t, joint 0 = t within the walk."""
    velocities = np.array([[0.2, 0.0], [0.6, 0.1]])
    commands = np.pad(velocities, ((0, 0), (0, 1)))
    step_time = np.array([[0.4, 0.4], [0.3, 0.5]])
    samples, base = np.zeros((2, SAMPLES, 26)), np.zeros((2, SAMPLES, 13))
    for gait, (first, second) in enumerate(step_time):
        half = SAMPLES // 2
        time = np.concatenate([np.linspace(0, first, half), first + np.linspace(0, second, half)])
        samples[gait, :, 0] = time
        base[gait, :, :2] = time[:, None] * velocities[gait]
        base[gait, :, 2], base[gait, :, 3] = 0.7, 1.0
    arrays = {"velocities": commands, "samples": samples, "base": base, "step_time": step_time}
    return GaitLibrary(arrays, {})


def test_replay_takes_the_nearest_gait_and_goes_on_for_ever():
    motion = Replay(library(), (0.7, 0.05, 0.0), period=0.02)
    frames = [motion.start(np.zeros(3))] + [motion.step(np.zeros(3)) for _ in range(100)]
    np.testing.assert_allclose(motion.velocity, [0.6, 0.1])
    last = frames[-1]
    assert last.time == pytest.approx(2.0)
    np.testing.assert_allclose(last.qpos[:3], [1.2, 0.2, 0.7], atol=1e-9)
    assert last.qpos[7] == pytest.approx(2.0 - 2 * 0.8)  # two walks of 0.8 s are over


def test_a_turning_gait_goes_along_its_arc():
    """A constant speed and yaw rate: the base is on a circle, its heading tangential to it."""
    straight, (speed, rate) = library(), (0.6, 0.3)
    time = np.concatenate(
        [np.linspace(0.0, 0.3, SAMPLES // 2), np.linspace(0.3, 0.8, SAMPLES // 2)]
    )
    base = straight.base[1:].copy()
    base[0, :, 0] = speed / rate * np.sin(rate * time)
    base[0, :, 1] = speed / rate * (1 - np.cos(rate * time))
    base[0, :, 3], base[0, :, 6] = np.cos(rate * time / 2), np.sin(rate * time / 2)
    arrays = {name: straight.arrays[name][1:] for name in ("samples", "step_time")}
    turning = GaitLibrary(
        {**arrays, "base": base, "velocities": np.array([[speed, 0.0, rate]])}, {}
    )
    motion = Replay(turning, (0.5, 0.0, 0.2), period=0.02)
    frames = [motion.start(np.zeros(3))] + [motion.step(np.zeros(3)) for _ in range(300)]
    angle = rate * np.array([frame.time for frame in frames])
    place = np.array([frame.qpos for frame in frames])
    circle = speed / rate * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
    np.testing.assert_allclose(place[:, :2], circle, atol=5e-4)  # linear between samples
    np.testing.assert_allclose(place[:, 6], np.sin(angle / 2), atol=1e-5)


@pytest.fixture(scope="module")
def config():
    return compose(["experiment=test"], CONF)


@pytest.mark.parametrize("random", [False, True])
def test_ignorant_agents_start_upright_and_repeat_themselves(config, random):
    def run():
        motion = simulate_agent(config.robot, config.env, config.evaluation.start, 3, random)
        frames = [motion.start(np.zeros(3))] + [motion.step(np.zeros(3)) for _ in range(5)]
        return np.array([frame.qpos for frame in frames])

    first = run()
    assert 0.6 < first[0, 2] < 0.8
    np.testing.assert_array_equal(first, run())


def test_a_push_changes_the_velocity_of_the_base(config):
    def velocity(push):
        motion = simulate_agent(config.robot, config.env, config.evaluation.start, 3, False)
        motion.start(np.zeros(3))
        motion.push(np.array(push))
        return motion.step(np.zeros(3)).velocity

    assert velocity([0.0, 0.4])[1] - velocity([0.0, 0.0])[1] > 0.2


class Counter:
    period = 0.1

    def __init__(self):
        self.steps, self.pushes = 0, []

    def start(self, velocity):
        self.steps = 0
        return self._frame()

    def step(self, velocity):
        self.steps += 1
        return self._frame()

    def push(self, velocity):
        self.pushes.append(velocity)

    def _frame(self):
        return Frame(self.steps * self.period, np.zeros(19), np.zeros(2), False)


def test_the_loop_obeys():
    motion, control = Counter(), Control((0.4, 0.0, 0.0), 3.0)
    assert loop.run(motion, control, lambda frame: True, 1.0, real_time=False).time == 1.0
    assert loop.run(motion, control, lambda frame: frame.time < 0.25, real_time=False).time < 0.35
    control.paused = True
    assert loop.run(motion, control, lambda frame: True, 1.0, real_time=False).time == 0.0
    control.paused = False
    control.push(0.0, 0.4)
    loop.run(motion, control, lambda frame: True, 1.0, real_time=False)
    assert len(motion.pushes) == 1


def test_headless_says_how_it_went(capsys, tmp_path):
    common = ["--conf", str(CONF), "--headless", "--seconds", "4"]
    assert main(["play", "zero", *common]) == 1  # nobody stands on two lines without control
    assert "agent zero: fell after" in capsys.readouterr().out
    assert main(["play", "--artefacts", str(tmp_path), *common]) == 1
    assert "make it with `snakemake -j2 policy`" in capsys.readouterr().err


def test_a_window_needs_a_display(capsys, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert main(["play", "zero", "--conf", str(CONF)]) == 1
    assert "use --web or --headless" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--gait", "0.6"], "--gait: expected VX VY [YAW_RATE], found 1 values"),
        (["--gait", "0.6", "0", "0.3", "1"], "--gait: expected VX VY [YAW_RATE], found 4 values"),
        (["--gait", "nan", "0"], "--gait: expected finite numbers, found nan 0"),
        (["zero", "--command", "inf", "0", "0"], "--command: expected finite numbers"),
        (["zero", "--command", "9", "0", "0"], "--command: expected VX between -1 and 3, found 9"),
        (["zero", "--seconds", "nan"], "--seconds: expected a positive number, found nan"),
        (["zero", "--seconds", "0"], "--seconds: expected a positive number, found 0"),
        (["zero", "--port", "99999"], "--port: expected a number from 0 to 65535, found 99999"),
    ],
)
def test_impossible_numbers_are_one_line(arguments, message, capsys):
    assert main(["play", *arguments, "--conf", str(CONF), "--headless"]) == 1
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_a_fall_leaves_no_log_behind(tmp_path, monkeypatch):
    """Uniform actions make MuJoCo warn about the accelerations of a fallen robot."""
    monkeypatch.chdir(tmp_path)
    main(["play", "random", "--conf", str(CONF), "--headless", "--seconds", "3"])
    assert list(tmp_path.iterdir()) == []
