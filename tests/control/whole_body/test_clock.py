"""Processor time of the parts of a tick, on a clock that is set by hand."""

from slider.control.whole_body import clock
from slider.control.whole_body.clock import TickClock


def test_times_are_means_over_ticks(monkeypatch):
    now = iter([1.0, 1.5, 2.0, 2.25, 3.0, 4.0])
    monkeypatch.setattr(clock.time, "process_time", lambda: next(now))
    found = TickClock()
    for part in ("model", "solution", "model"):
        with found.part(part):
            pass
    assert found.microseconds() == {"model": 1.5e6, "solution": 0.25e6}, "before the first tick"
    found.ticks = 4
    assert found.microseconds() == {"model": 0.375e6, "solution": 0.0625e6}
