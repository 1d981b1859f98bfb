"""What the figure of the capstan drive shows, against the formulas of the robot's page."""

from pathlib import Path

import numpy as np
import pytest

from slider.config.compose import compose
from slider.reports.figures.capstan import (
    ANKLE,
    SLIDE,
    angles_of,
    effort_limits,
    effort_region,
    no_load,
)
from slider.robot.transmission import Transmission

ROBOT = compose([], Path(__file__).parents[3] / "conf").robot
DRIVE = Transmission.of(ROBOT)
MOTOR, R, N = ROBOT.drives["capstan"], ROBOT.capstan.drum_radius, ROBOT.capstan.foot_ratio


def test_the_same_sense_slides_and_opposite_senses_turn_the_foot():
    slide, ankle = np.array([0.1, 0.0, 0.1]), np.array([0.0, 0.3, 0.3])
    same, opposite, both = angles_of(DRIVE, slide, ankle)
    np.testing.assert_allclose(same, [0.1 / R, 0.1 / R])
    np.testing.assert_allclose(opposite, [0.3 / N, -0.3 / N])
    np.testing.assert_allclose(both, same + opposite)


@pytest.mark.parametrize(("joint", "radius"), [(SLIDE, R), (ANKLE, N)])
def test_the_torque_speed_region_of_a_joint(joint, radius):
    fastest = no_load(DRIVE, joint)
    assert fastest == pytest.approx(MOTOR.speed * radius)
    low, high = effort_limits(DRIVE, joint, np.array([0.0, 0.75, 1.0, -1.0]) * fastest)
    full = 2 * MOTOR.torque / radius
    # Half the stall torque up to half the no-load speed, then down to nothing; braking in full.
    np.testing.assert_allclose(high, [full, 0.5 * full, 0.0, full], atol=1e-9)
    np.testing.assert_allclose(low, [-full, -full, -full, 0.0], atol=1e-9)


def test_force_and_torque_share_the_motors():
    corners = effort_region(DRIVE, 0.0)
    force, torque = 2 * MOTOR.torque / R, 2 * MOTOR.torque / N
    expected = [[-force, 0], [0, torque], [force, 0], [0, -torque], [-force, 0]]
    np.testing.assert_allclose(corners, expected, atol=1e-9)
    fast = effort_region(DRIVE, 0.8 * no_load(DRIVE, SLIDE))
    assert fast[:, 0].max() == pytest.approx(0.4 * force)
    assert fast[:, 1].max() == pytest.approx(0.7 * torque)
