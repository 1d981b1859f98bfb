"""What the figure of the capstan drive shows, against the formulas of the robot's page."""

from pathlib import Path

import numpy as np

from slider.config.compose import compose
from slider.reports.figures.capstan import angles_of
from slider.robot.transmission import Transmission

ROBOT = compose([], Path(__file__).parents[3] / "conf").robot
DRIVE = Transmission.of(ROBOT)
R, N = ROBOT.capstan.drum_radius, ROBOT.capstan.foot_ratio


def test_the_same_sense_slides_and_opposite_senses_turn_the_foot():
    slide, ankle = np.array([0.1, 0.0, 0.1]), np.array([0.0, 0.3, 0.3])
    same, opposite, both = angles_of(DRIVE, slide, ankle)
    np.testing.assert_allclose(same, [0.1 / R, 0.1 / R])
    np.testing.assert_allclose(opposite, [0.3 / N, -0.3 / N])
    np.testing.assert_allclose(both, same + opposite)
