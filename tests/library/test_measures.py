"""Use of the motors, clearance of feet, jumps between neighbouring gaits."""

from dataclasses import replace

import numpy as np
import pytest

from slider.config.convert import to_dict
from slider.library import measures
from slider.library.measures import neighbours, smoothness
from slider.library.reader import GaitLibrary
from slider.robot.names import NUM_JOINTS
from tests.env.synthetic import JOINTS, MOTORS
from tests.library.gaits import library as make_library

GAIT = 1


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> GaitLibrary:
    """Upright gaits at rest, but for a few spikes in the second gait.

    In sample 7 the two motors of the left leg make (400 N · 0.025 m ∓ 15 N m · 0.35) / 2, which is
    2.375 and 7.625 of 8 N m, and turn with 1.2 m/s / 0.025 m = 48 of 120 rad/s: the second has
    7.625 / 16 of its stall torque + 0.4 = 0.8765625 of the bus voltage.
    """
    made = make_library(tmp_path_factory.mktemp("measures"), [(0.0, 0.0), (0.5, 0.0)])
    arrays = dict(made.arrays)
    efforts, samples = np.zeros_like(arrays["efforts"]), np.zeros_like(arrays["samples"])
    efforts[GAIT, 7, JOINTS.index("left_slide")] = 400.0
    efforts[GAIT, 7, JOINTS.index("left_ankle")] = -15.0
    samples[GAIT, 7, NUM_JOINTS + JOINTS.index("left_slide")] = 1.2
    efforts[GAIT, 8, JOINTS.index("right_hip_roll")] = 30.0  # of 60 N m
    samples[GAIT, 3, NUM_JOINTS + JOINTS.index("right_slide")] = -1.5
    samples[GAIT, 4, NUM_JOINTS + JOINTS.index("left_hip_pitch")] = -12.0  # of 15 rad/s
    base = np.zeros_like(arrays["base"])
    base[..., 2], base[..., 3] = 0.64 + 0.045, 1.0
    motor = replace(made.robot.drives["capstan"], torque=8.0)  # for round numbers
    robot = replace(made.robot, drives={**made.robot.drives, "capstan": motor})
    arrays |= {"efforts": efforts, "samples": samples, "base": base}
    return GaitLibrary(arrays, {**made.attributes, "robot": to_dict(robot)})


def test_torques_and_shares_of_the_limits_by_hand(library):
    assert measures.slide_speed(library).tolist() == [0.0, 1.5]
    shares = measures.motor_shares(library)
    assert shares[0].max(axis=1) == pytest.approx([0.0, 0.953125], abs=1e-12)
    assert shares[1].max(axis=1) == pytest.approx([0.0, 0.8765625], abs=1e-12)
    torque, voltage = (dict(zip(MOTORS, share[GAIT], strict=True)) for share in shares)
    assert torque["left_leg_1"] == pytest.approx(2.375 / 8)
    assert torque["left_leg_2"] == pytest.approx(7.625 / 8)
    assert torque["right_hip_roll"] == 0.5
    assert voltage["right_hip_roll"] == 0.25  # half of the stall torque's half, at rest
    assert voltage["left_hip_pitch"] == pytest.approx(0.8)
    assert voltage["right_leg_1"] == voltage["right_leg_2"] == pytest.approx(0.5)
    idle = set(MOTORS) - {"left_leg_1", "left_leg_2", "right_hip_roll"}
    assert not any(torque[name] for name in idle)


def test_clearance_is_the_lower_end_of_the_swing_foot_at_mid_step(library):
    samples = library.arrays["samples"].copy()
    samples[0, 10, JOINTS.index("right_slide")] = -0.08  # middle of the left stance step
    samples[0, 31, JOINTS.index("left_slide")] = -0.07
    lifted = replace(library, arrays={**library.arrays, "samples": samples})
    assert measures.clearance(lifted, 0) == pytest.approx(0.07)
    samples[0, 31, JOINTS.index("left_ankle")] = 0.3  # the toe hangs down
    tilted = measures.clearance(lifted, 0)
    drop = 0.07 - tilted
    assert drop == pytest.approx(0.085 * np.sin(0.3) - (0.045 - 0.006) * (1 - np.cos(0.3)), 1e-6)


VELOCITIES = np.array(
    [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.3, 0.0, 0.0), (0.1, 0.1, 0.0), (0.0, -0.1, 0.0)]
)


def test_neighbours_follow_one_another_along_one_axis_of_the_velocity():
    turned = [*VELOCITIES[:2] + [0.0, 0.0, 0.3], VELOCITIES[0] + [0.0, 0.0, 0.6]]
    found = neighbours(np.array([*VELOCITIES, *turned]))
    found = {tuple(sorted(pair)) for pair in found.tolist()}
    assert found == {(0, 1), (1, 2), (1, 3), (0, 4), (5, 6), (0, 5), (1, 6), (5, 7)}


def test_jumps_are_shares_of_each_channel_s_range():
    samples = np.zeros((5, 3, 2))
    samples[:, :, 0] = np.array([0.0, 1.0, 10.0, 2.0, 0.0])[:, None]  # range 10
    samples[2, 1, 1] = -0.5  # range 0.5, one sample of one gait
    measured = smoothness(VELOCITIES, samples)
    jumps = {
        tuple(sorted(p)): j for p, j in zip(measured.pairs.tolist(), measured.jumps, strict=True)
    }
    np.testing.assert_allclose(jumps[0, 1], [0.1, 0.0])
    np.testing.assert_allclose(jumps[1, 2], [0.9, 1.0])
    np.testing.assert_allclose(jumps[1, 3], [0.1, 0.0])
    assert measured.largest == 1.0
    assert sorted(measured.worst[:2]) == [1, 2]
    assert measured.worst[2] == 1


def test_a_constant_channel_has_no_jump_and_a_single_gait_no_neighbour():
    assert smoothness(VELOCITIES, np.ones((5, 3, 2))).largest == 0.0
    alone = smoothness(VELOCITIES[:1], np.ones((1, 3, 2)))
    assert alone.largest == 0.0
