"""What the figure of the capstan drive shows, against the formulas of the robot's page."""

import numpy as np

from slider.config.convert import to_dict
from slider.library.reader import GaitLibrary
from slider.reports.figures.capstan import angles_of, caption, draw
from slider.reports.figures.style import style
from slider.robot.transmission import Transmission
from tests.config.composed import composed
from tests.library.gaits import MECHANISM, library
from tests.robot.lopsided import lopsided

ROBOT = composed().robot
DRIVE = Transmission.of(ROBOT)
R, N = ROBOT.capstan.drum_radius, ROBOT.capstan.foot_ratio


def test_the_same_sense_slides_and_opposite_senses_turn_the_foot():
    slide, ankle = np.array([0.1, 0.0, 0.1]), np.array([0.0, 0.3, 0.3])
    same, opposite, both = angles_of(DRIVE, slide, ankle)
    np.testing.assert_allclose(same, [0.1 / R, 0.1 / R])
    np.testing.assert_allclose(opposite, [0.3 / N, -0.3 / N])
    np.testing.assert_allclose(both, same + opposite)


def test_without_a_capstan_each_motor_has_a_panel_of_its_limits(tmp_path):
    made, robot = library(tmp_path, [(0.0, 0.0), (0.5, 0.0)]), to_dict(lopsided())
    robot = {name: robot[name] for name in MECHANISM}
    made = GaitLibrary(made.arrays, {**made.attributes, "robot": robot})
    with style():
        slide, ankle = draw(made).axes
    assert (slide.get_xlabel(), ankle.get_xlabel()) == ("speed [m/s]", "speed [rad/s]")
    force = slide.collections[0].get_paths()[0].vertices[:, 1]
    assert force.max() == 600.0
    assert "capstan" not in caption(made)
