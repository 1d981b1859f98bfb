"""The swing foot's reference goes over the apex and lands where and when it should."""

import numpy as np
import pytest

from slider.control.mpc import swing
from tests.env.synthetic import config

SETTINGS = config().control["mpc_wbc_tuned"].swing
TIME, APEX, PERIOD, GROUND = 0.3, 0.07, 0.005, 0.002


def fly(target_at) -> np.ndarray:
    """Reference (ticks, 3, 3) of one swing and 10 ticks beyond; ``target_at`` maps time → (2,)."""
    reference, path = swing.begin(np.array([[-0.2, 0.1, 0.0]])), []
    for tick in range(round(TIME / PERIOD) + 10):
        reference = swing.advance(
            reference,
            np.array([target_at(tick * PERIOD)]),
            np.array([tick * PERIOD]),
            np.array([TIME]),
            np.array([GROUND]),
            APEX,
            SETTINGS,
            PERIOD,
        )
        path.append(reference[0])
    return np.array(path)


def test_lands_on_the_foothold_in_time_and_sinks_on():
    path = fly(lambda t: (0.2, 0.12))
    end = round(TIME / PERIOD) - 1
    np.testing.assert_allclose(path[end, :2, 0], [0.2, 0.12], atol=1e-3)
    assert path[end, 2, 0] == pytest.approx(GROUND, abs=1e-3)
    assert path[:, 2, 0].max() == pytest.approx(APEX + GROUND, abs=2e-3)
    assert abs(int(path[:, 2, 0].argmax()) - end // 2) <= 3
    np.testing.assert_allclose(np.diff(path[end + 1 :, 2, 0]), -SETTINGS.search_velocity * PERIOD)


def test_a_foothold_that_moves_is_still_met_and_nothing_jumps():
    path = fly(lambda t: (0.2, 0.12) if t < 0.1 else (0.26, 0.08))
    end = round(TIME / PERIOD) - 1
    np.testing.assert_allclose(path[end, :2, 0], [0.26, 0.08], atol=2e-3)
    speed = np.diff(path[: end + 1, :2, 0], axis=0) / PERIOD
    assert np.abs(np.diff(speed, axis=0)).max() < 0.3  # [m/s] within a tick
