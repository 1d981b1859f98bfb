"""The observer: exact where the model is, better than the sensors where they are noisy."""

from dataclasses import replace

import numpy as np
import pytest

from slider.config.control import ObserverConfig
from slider.config.env import DisturbanceConfig
from slider.config.types import Interval
from slider.control.whole_body.observer import Observer, rotate, rotation_between
from slider.env.disturbance import Disturbance
from slider.env.physics import BatchedPhysics
from slider.env.starts import at_rest
from slider.env.state import RobotState
from slider.robot import names
from tests.control.walking import walk
from tests.env.synthetic import JOINTS, config, make_arrays, robot_config

COUNT, TICKS = 4, 40
DELAY = 0.02  # [s]


def disturbance(**changes) -> DisturbanceConfig:
    return replace(config().evaluation.disturbance, **changes)


def run(settings: DisturbanceConfig, gains: ObserverConfig) -> tuple[list[RobotState], ...]:
    """True, measured and estimated states while random torques act."""
    model = replace(config().env.physics, substeps=1)
    noise = Disturbance(settings, (3,))
    physics = BatchedPhysics(robot_config(), model, COUNT, 1, "torque", noise)
    observer = Observer(robot_config(), model, gains, COUNT)
    generator = np.random.default_rng(5)
    start = at_rest(robot_config(), config().evaluation.start, generator, COUNT)
    physics.reset(np.arange(COUNT), *start)
    true, measured, estimated = [physics.read()], [], []
    observer.reset(physics.measure(true[0]))
    for _ in range(TICKS):
        measured.append(physics.measure(true[-1]))
        estimated.append(observer.estimate(measured[-1]))
        torques = np.zeros((COUNT, names.NUM_JOINTS))
        torques[:, names.GAIT_JOINTS] = generator.normal(0.0, 5.0, (COUNT, len(names.GAIT_JOINTS)))
        observer.send(torques)
        physics.step(torques)
        true.append(physics.read())
    return true, measured, estimated


@pytest.mark.parametrize("delay", [0.0, 0.005, DELAY])
def test_predicts_the_true_state_at_which_the_torques_will_act(delay):
    settings = disturbance(delay=Interval(delay, delay))
    true, _, estimated = run(settings, ObserverConfig(delay, 0.3, 0.2))
    late = round(delay / 0.005)
    for tick in range(TICKS - late):
        found, expected = estimated[tick], true[tick + late]
        np.testing.assert_allclose(found.qpos, expected.qpos, atol=1e-9)
        np.testing.assert_allclose(found.qvel, expected.qvel, atol=1e-7)
        np.testing.assert_allclose(found.foot_forces, expected.foot_forces, atol=1e-5)


def test_is_less_noisy_than_the_sensors():
    """Not for the light feet, which the random torques throw about on the ground."""
    sensing = config("evaluation=robust").evaluation.disturbance.sensing
    true, measured, estimated = run(disturbance(sensing=sensing), ObserverConfig(0.0, 0.3, 0.2))
    legs = [i for i, name in enumerate(JOINTS) if not name.endswith("ankle")]
    columns = [*range(6), *(6 + i for i in legs)]

    def error(states: list[RobotState]) -> float:
        pairs = list(zip(states, true, strict=False))[10:]
        return float(np.sqrt(np.mean([(s.qvel - t.qvel)[:, columns] ** 2 for s, t in pairs])))

    assert error(estimated) < 0.7 * error(measured)


def test_robots_given_up_leave_the_others_as_they_are():
    model, measured = replace(config().env.physics, substeps=1), make_arrays(COUNT)
    gains = ObserverConfig(DELAY, 0.3, 0.2)
    both = [Observer(robot_config(), model, gains, COUNT) for _ in range(2)]
    for observer in both:
        observer.reset(measured)
    both[0].deactivate(np.arange(COUNT) == 1)
    torques = np.outer(np.arange(1.0, COUNT + 1), np.ones(names.NUM_JOINTS))
    for _ in range(8):
        some, whole = (observer.estimate(measured) for observer in both)
        for observer in both:
            observer.send(torques)
    others = [0, 2, 3]
    np.testing.assert_array_equal(some.qpos[others], whole.qpos[others])
    assert np.abs(some.qvel[1] - whole.qvel[1]).max() > 1e-3


def test_turns_between_orientations():
    generator = np.random.default_rng(2)
    old, new = generator.normal(size=(2, 5, 4))
    old /= np.linalg.norm(old, axis=1, keepdims=True)
    new /= np.linalg.norm(new, axis=1, keepdims=True)
    found = rotate(old, rotation_between(old, new))
    np.testing.assert_allclose(np.abs((found * new).sum(axis=1)), 1.0, atol=1e-12)
    np.testing.assert_allclose(rotation_between(old, old), 0.0, atol=1e-7)


def test_walks_with_noise_and_delay():
    """Without the observer some of these robots fall."""
    sensing = config("evaluation=robust").evaluation.disturbance.sensing
    drawn = Disturbance(disturbance(delay=Interval(DELAY, DELAY), sensing=sensing), (3,))
    segment = 4.0, (0.4, 0.0, 0.0)
    recording, _ = walk("mpc_wbc_observer", segment, noise=True, count=COUNT, drawn=drawn)
    assert recording.survived.all()
