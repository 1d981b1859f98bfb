"""The clock: at the pace of the library, and at rest where it is told to stand."""

import numpy as np

from slider.env.phase import Clock, standing
from tests.env.synthetic import STEP_TIME, gait_table

PERIOD = 0.02


def run(halt: bool, command: list[float], start: float, steps: int) -> np.ndarray:
    clock = Clock(gait_table().times, PERIOD, 1, halt)
    clock.phase[:] = start
    phases = []
    for _ in range(steps):
        clock.advance(np.array([command]))
        phases.append(clock.phase[0])
    return np.array(phases)


def test_a_walk_takes_two_steps():
    steps = round(2 * STEP_TIME / PERIOD)
    phases = run(False, [0.0, 0.0, 0.0, 0.0], 0.0, steps + 1)
    np.testing.assert_allclose(phases[0], 1 / steps)
    np.testing.assert_allclose(phases[-1], phases[0], atol=1e-12)


def test_stays_at_the_next_change_of_feet_at_zero_command():
    for start, end in ((0.0, 0.0), (0.2, 0.5), (0.5, 0.5), (0.51, 0.0)):
        phases = run(True, [0.0, 0.0, 0.0, 0.3], start, 60)  # a heading error is no command
        assert phases[-1] == phases[-2] == end


def test_goes_on_with_any_command():
    for command in ([0.1, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0], [0.0, 0.0, -0.2, 0.0]):
        halting = run(True, command, 0.3, 60)
        np.testing.assert_array_equal(halting, run(False, command, 0.3, 60))
        assert np.ptp(halting) > 0.5


def test_standing_is_an_exact_zero():
    commands = np.array([[0, 0, 0, 1], [0, 1e-9, 0, 0], [0, 0, -0.1, 0]])
    np.testing.assert_array_equal(standing(commands), [True, False, False])
