"""What counts as a fall."""

import numpy as np

from slider.env import terminations
from slider.robot.kinematics import quaternion_from_tilt, rotation_from_quaternion
from tests.env.synthetic import make_state

# Design, section 3: base z < 0.40 m, tilt > 45°, or a body other than a foot on the ground.
PROTOCOL = {"base_height": 0.4, "tilt": np.pi / 4, "body_contact": 0.0}


def test_height_and_contacts():
    base = [[0, 0, 0.399], [9, 9, 0.401], [0, 0, 2.0], [0, 0, 2.0]]
    state = make_state(4, base_position=base, body_contacts=[0, 0, 1, 2])
    np.testing.assert_array_equal(terminations.failed(state, PROTOCOL), [True, False, True, True])


def test_tilt_in_any_direction():
    roll = np.radians([44.9, 45.1, 0.0, 0.0, 33.0, 30.0, 180.0])
    pitch = np.radians([0.0, 0.0, -44.9, -45.1, 33.0, -30.0, 0.0])
    rotation = rotation_from_quaternion(quaternion_from_tilt(roll, pitch))
    state = make_state(7, gravity=-rotation[:, 2, :], rotation=rotation)
    expected = np.degrees(np.arccos(rotation[:, 2, 2])) > 45.0
    assert list(expected[:4]) == [False, True, False, True]
    np.testing.assert_array_equal(terminations.failed(state, PROTOCOL), expected)
