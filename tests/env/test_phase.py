"""The clock: at the pace of the library, and at rest where standing is commanded."""

import numpy as np
import pytest
import torch

from slider.config.env import HaltConfig
from slider.env.interface import FLOAT64
from slider.env.phase import Clock
from tests.env.synthetic import gait_table

PERIOD = 0.02
NEVER, HALT = HaltConfig(0.0, 0.0), HaltConfig(0.2, 0.4)
STAND, GO = [0.0, 0.0, 0.0, 0.3], [0.1, 0.0, 0.0, 0.0]  # a heading error is no command


def tensor(row: list[float]) -> torch.Tensor:
    return FLOAT64.new_tensor([row])


def make_clock(halt: HaltConfig, start: float = 0.0, speed: float = 1.0) -> Clock:
    clock = Clock(gait_table().times, PERIOD, 1, halt, FLOAT64)
    clock.reset(slice(None), start, tensor(STAND), torch.tensor([speed]))
    return clock


def run(
    clock: Clock, command: list[float], steps: int, mean_speed: float = 0.0, speed: float = 0.0
) -> np.ndarray:
    phases = []
    for _ in range(steps):
        speeds = (FLOAT64.new_tensor([value]) for value in (mean_speed, speed))
        clock.advance(tensor(command), tensor(command[:2]), *speeds)
        phases.append(clock.phase[0].item())
    return np.array(phases)


@pytest.mark.parametrize(("start", "end"), [(0.0, 0.0), (0.2, 0.5), (0.5, 0.5), (0.51, 0.0)])
def test_stays_at_the_next_change_of_feet_at_zero_command(start, end):
    clock = make_clock(HALT, start)
    assert not clock.halted[0], "too fast at its start"
    run(clock, STAND, 1)
    assert clock.halted[0] == (start in (0.0, 0.5))
    phases = run(clock, STAND, 60)
    assert clock.halted[0]
    assert phases[-1] == phases[-2] == end


def test_steps_until_it_is_slow_and_again_when_it_is_pushed():
    clock = make_clock(HALT, 0.3)
    free = run(make_clock(NEVER, 0.3), STAND, 60)
    np.testing.assert_array_equal(run(clock, STAND, 60, mean_speed=0.3), free)
    swaying = run(make_clock(HALT, 0.3), STAND, 60, mean_speed=0.1, speed=0.5)
    np.testing.assert_array_equal(swaying, free)
    run(clock, STAND, 30, mean_speed=0.1, speed=0.3)
    assert clock.halted[0]
    run(clock, STAND, 5, mean_speed=0.3, speed=0.3)
    assert clock.halted[0], "slower than the speed at which it has to step"
    run(clock, STAND, 1, mean_speed=0.1, speed=0.5)
    assert not clock.halted[0]
    assert np.ptp(run(clock, STAND, 30, mean_speed=0.3)) > 0.5, "still too fast to stand"


def test_a_start_at_a_change_of_feet_may_stand_at_once():
    slow, fast = [(HALT, start, 0.1) for start in (0.0, 0.5, 0.1)], (HALT, 0.0, 0.3)
    clocks = [make_clock(*case) for case in (*slow, fast, (NEVER, 0.0, 0.0))]
    assert [clock.halted.item() for clock in clocks] == [True, True, False, False, False]
    clocks[0].reset(slice(None), 0.0, tensor(GO), torch.zeros(1))
    assert not clocks[0].halted[0]
