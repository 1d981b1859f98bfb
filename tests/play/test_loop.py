"""Keys and what they do to the command."""

import numpy as np
import pytest

from slider.play import window
from slider.play.loop import PUSH, Control


@pytest.mark.parametrize(
    ("key", "expected"),
    [(265, (0.5, 0, 0)), (264, (0.3, 0, 0)), (44, (0.4, 0.05, 0)), (263, (0.4, 0, 0.1))],
)
def test_keys_change_the_command(key, expected):
    control = Control((0.4, 0.0, 0.0), 2.6)
    window.on_key(control, key)
    np.testing.assert_allclose(control.velocity, expected)


def test_commands_stay_within_their_limits():
    control = Control((0.0, 0.0, 0.0), 2.6)
    for _ in range(100):
        window.on_key(control, 265)
    assert control.velocity[0] == 2.6


def test_wishes_are_granted_once():
    control = Control((0.4, 0.0, 0.0), 2.6)
    window.on_key(control, 257)
    window.on_key(control, 259)
    np.testing.assert_allclose(control.take_push(), [0.0, PUSH])
    assert control.take_push() is None
    assert control.take_restart()
    assert not control.take_restart()


def test_end_goes_round_the_cameras():
    control, seen = Control((0.4, 0.0, 0.0), 2.6), []
    for _ in range(3):
        seen.append(control.take_camera())
        assert control.take_camera() is None
        window.on_key(control, 269)
    assert seen == ["side", "front", "side"]


def test_home_stands_and_space_pauses():
    control = Control((0.4, 0.1, 0.2), 2.6)
    window.on_key(control, 268)
    window.on_key(control, 32)
    assert not control.velocity.any()
    assert control.paused
