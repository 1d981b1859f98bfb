"""Use of the drives and clearance of feet."""

from dataclasses import replace

import numpy as np
import pytest

from slider.library import loads
from slider.library.contents import LibraryContents
from slider.robot.names import JOINTS, NUM_JOINTS
from tests.library.gaits import library as make_library

GAIT = 1


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> LibraryContents:
    """Upright gaits at rest, but for one spike per drive quantity in the second gait."""
    made = make_library(tmp_path_factory.mktemp("loads"), [(0.0, 0.0), (0.5, 0.0)])
    arrays = dict(made.arrays)
    efforts, samples = np.zeros_like(arrays["efforts"]), np.zeros_like(arrays["samples"])
    efforts[GAIT, 7, JOINTS.index("left_ankle")] = -15.0  # of 20 N m
    efforts[GAIT, 8, JOINTS.index("right_hip_roll")] = 30.0  # of 60 N m
    efforts[GAIT, 9, JOINTS.index("right_slide")] = -100.0  # of 400 N
    samples[GAIT, 3, NUM_JOINTS + JOINTS.index("left_slide")] = -1.5  # of 3 m/s
    samples[GAIT, 4, NUM_JOINTS + JOINTS.index("left_hip_yaw")] = 6.0  # of 15 rad/s
    samples[GAIT, 4, NUM_JOINTS + JOINTS.index("left_hip_pitch")] = -7.5
    base = np.zeros_like(arrays["base"])
    base[..., 2], base[..., 3] = 0.64 + 0.045, 1.0
    return replace(made, arrays=arrays | {"efforts": efforts, "samples": samples, "base": base})


def test_shares_of_the_limits(library):
    assert loads.peak_torque_share(library).tolist() == [0.0, 0.75]
    assert loads.slide_force_share(library).tolist() == [0.0, 0.25]
    assert loads.slide_speed_share(library).tolist() == [0.0, 0.5]


def test_peaks_name_the_joint_the_limit_and_the_unit(library):
    found = [(p.quantity, p.joint, p.value, p.limit, p.unit) for p in loads.peaks(library, GAIT)]
    assert found == [
        ("torque", "left_ankle", 15.0, 20.0, "N m"),
        ("speed", "left_hip_pitch", 7.5, 15.0, "rad/s"),
        ("slide force", "right_slide", 100.0, 400.0, "N"),
        ("slide speed", "left_slide", 1.5, 3.0, "m/s"),
    ]


def test_clearance_is_the_lower_end_of_the_swing_foot_at_mid_step(library):
    samples = library.arrays["samples"].copy()
    samples[0, 10, JOINTS.index("right_slide")] = -0.08  # middle of the left stance step
    samples[0, 31, JOINTS.index("left_slide")] = -0.07
    lifted = replace(library, arrays=library.arrays | {"samples": samples})
    assert loads.clearance(lifted, 0) == pytest.approx(0.07)
    samples[0, 31, JOINTS.index("left_ankle")] = 0.3  # the toe hangs down
    tilted = loads.clearance(lifted, 0)
    drop = 0.07 - tilted
    assert drop == pytest.approx(0.085 * np.sin(0.3) - (0.045 - 0.006) * (1 - np.cos(0.3)), 1e-6)
