"""A controller receives a noisy, consistent state; nobody else does."""

from dataclasses import fields

import numpy as np
import pytest

from slider.config.env import SensingConfig
from slider.env.disturbance import with_noise
from slider.env.state import RobotState
from slider.robot import names
from tests.env.synthetic import JOINTS, disturbed_physics, make_arrays, stand

COUNT = 4000
SILENT = {item.name: 0.0 for item in fields(SensingConfig)}
SLIDES = np.array([name.endswith("slide") for name in JOINTS])
VALUES = {
    "joint_position": lambda s: s.joint_positions[:, ~SLIDES],
    "slide_position": lambda s: s.joint_positions[:, SLIDES],
    "joint_velocity": lambda s: s.joint_velocities[:, ~SLIDES],
    "slide_velocity": lambda s: s.joint_velocities[:, SLIDES],
    "angular_velocity": lambda s: s.angular_velocity,
    "orientation": lambda s: np.stack([s.gravity[:, 1], -s.gravity[:, 0], -s.yaw], axis=1),
    "linear_velocity": lambda s: s.linear_velocity,
    "base_height": lambda s: s.base_height,
}


def measured(**noise: float) -> tuple[RobotState, RobotState]:
    """The true and the measured state of robots at rest."""
    true = make_arrays(COUNT)
    normal = np.random.default_rng(0).standard_normal((COUNT, 34))
    return true, with_noise(true, SensingConfig(**{**SILENT, **noise}), normal)


@pytest.mark.parametrize("quantity", VALUES)
def test_standard_deviation_of_one_quantity_and_none_of_the_others(quantity):
    true, noisy = measured(**{quantity: 0.02})
    errors = {name: value(noisy) - value(true) for name, value in VALUES.items()}
    found = errors.pop(quantity)
    np.testing.assert_allclose(found.std(axis=0), 0.02, rtol=0.06)
    np.testing.assert_allclose(found.mean(axis=0), 0.0, atol=0.0015)
    for name, error in errors.items():
        np.testing.assert_allclose(error, 0.0, atol=1e-12, err_msg=name)


def test_the_orientation_is_one_whoever_looks_at_it():
    """Heading, gravity, rotation and MuJoCo's coordinates agree."""
    _, noisy = measured(orientation=0.05, linear_velocity=0.1)
    np.testing.assert_allclose(np.linalg.norm(noisy.quaternion, axis=1), 1.0)
    np.testing.assert_allclose(-noisy.rotation[:, 2], noisy.gravity)
    x, y = noisy.qvel[:, :2].T
    ahead, left = np.cos(noisy.yaw), np.sin(noisy.yaw)
    expected = np.stack([x * ahead + y * left, y * ahead - x * left], axis=1)
    np.testing.assert_allclose(noisy.heading_velocity, expected, atol=1e-12)


def test_the_noise_of_an_instant_is_the_same_at_every_control_rate():
    slow, fast = (
        stand(disturbed_physics(3, "sensing.joint_velocity=0.2", substeps=substeps), 0.1)
        for substeps in (4, 1)
    )
    np.testing.assert_allclose(rate_noise(slow), rate_noise(fast), atol=1e-12)
    first = rate_noise(slow)
    np.testing.assert_array_equal(rate_noise(slow), first)
    slow.step(np.zeros((3, names.NUM_JOINTS)))
    assert not np.isclose(rate_noise(slow), first).any()


def rate_noise(physics) -> np.ndarray:
    """Error of the measured speeds of the hinges (N, 10) [rad/s]."""
    true = physics.read()
    return (physics.measure(true).joint_velocities - true.joint_velocities)[:, ~SLIDES]
