"""A rollout records what happened, step by step, and a fall is for ever."""

from dataclasses import replace

import numpy as np
import pytest

from slider.env.physics import BatchedPhysics
from slider.env.rollout import Controller, Recording, roll_out
from slider.env.state import RobotState
from slider.robot.mjcf import nominal_qpos
from slider.robot.names import NUM_JOINTS
from tests.env.synthetic import config, disturbed_physics, make_arrays, make_physics, robot_config

COUNT = 4


class Stiff:
    """Holds the nominal pose and notes what it is given."""

    def __init__(self) -> None:
        self.seen: list[RobotState] = []
        self.commanded: list[tuple[int, np.ndarray]] = []  # control steps before, velocity

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        self.velocity = velocity

    def set_velocity(self, velocity: np.ndarray) -> None:
        self.commanded.append((len(self.seen), velocity))

    def control(self, state: RobotState) -> np.ndarray:
        self.seen.append(state)
        return np.zeros((state.num_robots, NUM_JOINTS))


def starts() -> tuple[np.ndarray, np.ndarray]:
    """Robot 0 stands, 1 is thrown upwards, 2 starts lying, 3 walks into the air."""
    qpos, qvel = np.tile(nominal_qpos(robot_config()), (COUNT, 1)), np.zeros((COUNT, 18))
    qvel[1, 2] = 1.0
    qpos[2, 2] = 0.2
    qvel[3, 0] = 0.3
    return qpos, qvel


def roll(controller: Controller, physics: BatchedPhysics | None = None, **changes) -> Recording:
    """For 0.4 s from the starts, at zero command, but for ``changes``."""
    env = config("experiment=test").env
    env = replace(env, termination=replace(env.termination, terms={"base_height": 0.4}))
    physics = physics or make_physics(COUNT)
    values = {"start": starts(), "command": np.zeros((physics.num_robots, 3)), "duration": 0.4}
    return roll_out(controller, physics, env, **(values | changes))


@pytest.mark.parametrize("substeps", [4, 1])
def test_the_controller_is_called_once_per_step_of_its_plant_with_the_latest_state(substeps):
    """A plant with shorter steps asks more often and is recorded as often."""
    settings = replace(config("experiment=test").env.physics, substeps=substeps)
    physics = BatchedPhysics(robot_config(), settings, COUNT, 1, "torque")
    controller, shares, command = Stiff(), [], np.full((COUNT, 3), 0.1)
    recording = roll(controller, physics, command=command, progress=shares.append)
    assert len(controller.seen) == 20 * 4 // substeps
    assert recording.alive.shape == (20, COUNT)
    np.testing.assert_array_equal(controller.velocity, command)
    assert not controller.commanded, "the command is constant"
    np.testing.assert_array_equal(controller.seen[0].joint_positions, starts()[0][:, 7:])
    later = controller.seen[4 // substeps :: 4 // substeps]
    for state, velocity in zip(later, recording.velocity[:-1], strict=True):
        np.testing.assert_array_equal(state.heading_velocity, velocity)
    np.testing.assert_allclose(shares, np.arange(1, 21) / 20)


def test_a_robot_that_gets_up_stays_fallen(monkeypatch):
    """Heights that dip below the limit for one step only."""
    physics, heights = make_physics(2), [0.7, 0.7, 0.3, 0.7, 0.7]
    states = (make_arrays(2, base_position=[[0, 0, 0.7], [0, 0, height]]) for height in heights)
    monkeypatch.setattr(physics, "read", lambda: next(states))
    recording = roll(Stiff(), physics, start=[x[:2] for x in starts()], duration=0.08)
    np.testing.assert_array_equal(recording.alive[:, 0], True)
    np.testing.assert_array_equal(recording.alive[:, 1], [True, False, False, False])
    np.testing.assert_array_equal(recording.survived, [True, False])


def test_the_controller_is_told_of_changes_only():
    controller, commands = Stiff(), np.zeros((20, COUNT, 3))
    commands[5:, :, 0] = 0.4
    commands[12:, 1, 2] = 0.3
    recording = roll(controller, command=commands)
    assert not controller.velocity.any()
    assert [step for step, _ in controller.commanded] == [5, 12]
    for step, velocity in controller.commanded:
        np.testing.assert_array_equal(velocity, commands[step])
    np.testing.assert_array_equal(recording.command, commands)


def test_the_controller_is_told_the_measured_state_and_the_recording_is_true():
    controller = Stiff()
    noisy = disturbed_physics(COUNT, "sensing.linear_velocity=0.5", "sensing.base_height=0.5")
    recording, plain = roll(controller, noisy), roll(Stiff())
    np.testing.assert_array_equal(recording.velocity, plain.velocity)
    np.testing.assert_array_equal(recording.alive, plain.alive)
    received = np.stack([state.heading_velocity for state in controller.seen[1:]])
    assert 0.3 < (received - plain.velocity[:-1]).std() < 0.7


def test_a_robot_that_blew_up_within_a_control_step_is_lost():
    """The plant puts it back upright at once: at the end of the control step nothing shows."""

    class Breaking(Stiff):
        def control(self, state: RobotState) -> np.ndarray:
            targets = super().control(state)
            if len(self.seen) == 4 * 5 + 2:  # the second of four calls in the sixth control step
                targets[0, 3] = np.nan
            return targets

    recording = roll(Breaking(), make_physics(2, substeps=1), start=[x[[0, 0]] for x in starts()])
    assert recording.diverged.tolist() == [True, False]
    np.testing.assert_array_equal(recording.alive[:, 0], np.arange(20) < 5)
    assert recording.alive[:, 1].all()


def test_a_controller_that_gives_up_leaves_the_others_as_they_are():
    """Robot 2 lies from the start and is not simulated further."""

    class Tiring(Stiff):
        def deactivate(self, robots: np.ndarray) -> None:
            self.given_up = robots

    controller = Tiring()
    found, whole = roll(controller), roll(Stiff())
    assert controller.given_up.tolist() == [False, False, True, False]
    np.testing.assert_array_equal(found.alive, whole.alive)
    np.testing.assert_array_equal(found.diverged, whole.diverged)
    pairs = zip(found.contacts, whole.contacts, strict=True)
    for mine, theirs in ((found.velocity, whole.velocity), (found.power, whole.power), *pairs):
        np.testing.assert_array_equal(mine[:, [0, 1, 3]], theirs[:, [0, 1, 3]])
    assert np.ptp(found.position[1:, 2], axis=0).max() == 0.0
    assert np.ptp(whole.velocity[1:, 2], axis=0).max() > 0.0
    last = Tiring()
    ended = roll(last, make_physics(2), start=[x[[2, 2]] for x in starts()])
    assert len(last.seen) == 1, "nobody is left"
    assert not ended.alive.any()
    assert (ended.alive.shape, len(ended.contacts.forces)) == ((20, 2), 80), "all rows"
