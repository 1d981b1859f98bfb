"""Keys and what they do to the velocity; the loop around a motion."""

from unittest.mock import Mock

import numpy as np
import pytest

from slider.env.rollout import Frame
from slider.play import loop, window
from slider.play.loop import PUSH, Control


@pytest.mark.parametrize(
    ("key", "expected"),
    [(265, (0.5, 0, 0)), (264, (0.3, 0, 0)), (44, (0.4, 0.05, 0)), (263, (0.4, 0, 0.1))],
)
def test_keys_change_the_velocity(key, expected):
    control = Control((0.4, 0.0, 0.0), 2.6)
    window.on_key(control, key)
    np.testing.assert_allclose(control.velocity, expected)


def test_requests_of_keys_are_served_once():
    """Speeds stay within their limits; end goes round the cameras, home stands, space pauses."""
    control, seen = Control((0.0, 0.1, 0.2), 2.6), []
    for key in (*[265] * 100, 257, 259):
        window.on_key(control, key)
    assert control.velocity[0] == 2.6
    np.testing.assert_allclose(control.take_push(), [0.0, PUSH])
    assert control.take_push() is None
    assert (control.take_restart(), control.take_restart()) == (True, False)
    for _ in range(3):
        seen += [control.take_camera(), control.take_camera()]
        window.on_key(control, 269)
    assert seen == ["side", None, "front", None, "side", None]
    window.on_key(control, 268)
    window.on_key(control, 32)
    assert not control.velocity.any()
    assert control.paused


class Counter:
    period = 0.1

    def __init__(self):
        self.push = Mock()

    def start(self, velocity):
        self.steps = -1
        return self.step(velocity)

    def step(self, velocity):
        self.steps += 1
        return Frame(self.steps * self.period, np.zeros(19), np.zeros(2), False)


def test_the_loop_ends_pauses_and_pushes():
    motion, control = Counter(), Control((0.4, 0.0, 0.0), 3.0)
    assert loop.run(motion, control, lambda frame: True, 1.0, real_time=False).time == 1.0
    assert loop.run(motion, control, lambda frame: frame.time < 0.25, real_time=False).time < 0.35
    control.paused = True
    assert loop.run(motion, control, lambda frame: True, 1.0, real_time=False).time == 0.0
    control.paused = False
    control.push(0.0, 0.4)
    loop.run(motion, control, lambda frame: True, 1.0, real_time=False)
    motion.push.assert_called_once()
