"""Turns about the vertical: heading components, their way back, and yaws."""

import numpy as np

from slider.robot.kinematics import about_z, rotation_from_quaternion, turn_to_heading, yaw_of


def test_a_quarter_turn_by_hand():
    np.testing.assert_allclose(
        turn_to_heading(np.array([[2.0, 1.0, 9.0]]), np.array([np.pi / 2])), [[1.0, -2.0]]
    )


def test_the_way_back_and_the_rotation_matrix_agree_for_any_shape():
    rng = np.random.default_rng(4)
    vectors, yaw = rng.standard_normal((6, 5, 2)), rng.uniform(-4.0, 4.0, (6, 5))
    heading = turn_to_heading(vectors, yaw)
    np.testing.assert_allclose(turn_to_heading(heading, -yaw), vectors, atol=1e-14)
    matrices = about_z(yaw.ravel())[:, :2, :2]
    expected = np.einsum("nji,nj->ni", matrices, vectors.reshape(-1, 2))
    np.testing.assert_allclose(heading.reshape(-1, 2), expected, atol=1e-15)


def test_the_yaw_is_that_of_the_nose_whatever_the_tilt():
    quaternion = np.random.default_rng(5).standard_normal((20, 4))
    quaternion /= np.linalg.norm(quaternion, axis=1, keepdims=True)
    rotation = rotation_from_quaternion(quaternion)
    nose = turn_to_heading(rotation[:, :, 0], yaw_of(rotation))
    np.testing.assert_allclose(nose[:, 1], 0.0, atol=1e-14)
    assert (nose[:, 0] > 0).all()
