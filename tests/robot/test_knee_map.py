import numpy as np
import pytest

from slider.robot import knee_map

L1 = L2 = 0.36
THETA = np.linspace(0.1, 1.2, 2001)
LENGTHS = [(0.36, 0.36), (0.40, 0.32), (0.30, 0.42)]


@pytest.mark.parametrize(("l1", "l2"), LENGTHS)
def test_exact_positions_put_the_ankle_where_the_knee_leg_has_it(l1, l2):
    rng = np.random.default_rng(0)
    hip, ankle = rng.uniform(-0.6, 0.6, (2, 100))
    theta = rng.uniform(0.05, 1.7, 100)
    leg = knee_map.positions(hip, theta, ankle, l1, l2)
    # Rotation by angle a about +y takes (0, −l) in the x-z plane to (−l sin a, −l cos a).
    shank = hip - theta
    x = -l1 * np.sin(hip) - l2 * np.sin(shank)
    z = -l1 * np.cos(hip) - l2 * np.cos(shank)
    np.testing.assert_allclose(-leg.length * np.sin(leg.hip_pitch), x, atol=1e-14)
    np.testing.assert_allclose(-leg.length * np.cos(leg.hip_pitch), z, atol=1e-14)
    np.testing.assert_allclose(leg.hip_pitch + leg.ankle, shank + ankle, atol=1e-14)


@pytest.mark.parametrize(("l1", "l2"), LENGTHS)
def test_exact_velocities_are_the_derivative_of_the_positions(l1, l2):
    h = 1e-6
    theta, zero = THETA, np.zeros_like(THETA)
    above = knee_map.positions(zero, theta + h, zero, l1, l2)
    below = knee_map.positions(zero, theta - h, zero, l1, l2)
    rate = knee_map.velocities(zero, theta, np.ones_like(theta), zero, l1, l2)
    for name in ("hip_pitch", "length", "ankle"):
        slope = (getattr(above, name) - getattr(below, name)) / (2 * h)
        np.testing.assert_allclose(getattr(rate, name), slope, atol=1e-9)


def test_paper_variant_is_the_matrix_as_printed():
    one = np.ones_like(THETA)
    length = np.sqrt(L1**2 + L2**2 + 2 * L1 * L2 * np.cos(THETA))
    leg = knee_map.positions(0.3 * one, THETA, -0.2 * one, L1, L2, "paper")
    np.testing.assert_allclose(leg.hip_pitch, 0.3 - L2 / length * THETA)
    np.testing.assert_allclose(leg.ankle, -0.2 - L1 / length * THETA)
    np.testing.assert_allclose(leg.length, length)
    speed = knee_map.velocities(0.3 * one, THETA, 2 * one, -0.2 * one, L1, L2, "paper")
    np.testing.assert_allclose(speed.hip_pitch, 0.3 - L2 / length * np.cos(THETA) * 2)
    np.testing.assert_allclose(speed.ankle, -0.2 - L1 / length * np.cos(THETA) * 2)
    np.testing.assert_allclose(speed.length, -2 * L1 * L2 * np.cos(THETA) * 2)


def test_paper_variant_is_off_by_what_the_documentation_says():
    zero = np.zeros_like(THETA)
    exact = knee_map.positions(zero, THETA, zero, L1, L2)
    paper = knee_map.positions(zero, THETA, zero, L1, L2, "paper")
    assert np.abs(paper.hip_pitch - exact.hip_pitch).max() == pytest.approx(0.127, abs=5e-4)
    assert np.abs(paper.ankle - exact.ankle).max() == pytest.approx(0.127, abs=5e-4)
    slides = [knee_map.rates(THETA, L1, L2, v)[2] for v in knee_map.VARIANTS]
    assert np.abs(slides[1] - slides[0]).max() == pytest.approx(0.24, abs=5e-3)


def test_slide_force_does_the_work_of_the_three_torques():
    rng = np.random.default_rng(1)
    theta = rng.uniform(0.1, 1.7, 50)
    knee, hip, ankle = rng.normal(size=(3, 50)) * 20
    rates = rng.normal(size=(3, 50))
    slide = knee_map.slide_force(knee, hip, ankle, theta, L1, L2)
    speed = knee_map.velocities(rates[0], theta, rates[1], rates[2], L1, L2)
    before = hip * rates[0] + knee * rates[1] + ankle * rates[2]
    after = hip * speed.hip_pitch + slide * speed.length + ankle * speed.ankle
    np.testing.assert_allclose(after, before, rtol=1e-11, atol=1e-11)


def test_an_unknown_variant_is_refused():
    with pytest.raises(ValueError, match="exact"):
        knee_map.positions(THETA, THETA, THETA, L1, L2, "printed")
    with pytest.raises(ValueError, match="exact"):
        knee_map.rates(THETA, L1, L2, "printed")
