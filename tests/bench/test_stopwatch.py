"""The stopwatch books time on the innermost part, and leaves no trace."""

import pytest

from slider.bench import stopwatch
from slider.bench.stopwatch import Stopwatch


class Machine:
    """Its work takes time on a clock of its own."""

    def __init__(self) -> None:
        self._now = 0.0

    def process_time(self) -> float:
        return self._now

    def outer(self) -> str:
        self._now += 4.0
        self.inner()
        self._now += 1.0
        return "done"

    def inner(self) -> None:
        self._now += 8.0


def test_time_counts_for_the_part_that_spends_it(monkeypatch):
    machine, watch = Machine(), Stopwatch()
    monkeypatch.setattr(stopwatch, "time", machine)
    with watch.watching({"outer": (machine, "outer"), "inner": (machine, "inner")}):
        assert machine.outer() == "done"
    assert watch.seconds == {"outer": 5.0, "inner": 8.0}
    before = dict(watch.seconds)
    machine.outer()
    assert watch.seconds == before, "nothing is timed outside the block"
    assert vars(machine).keys() == {"_now"}


def test_an_attribute_of_the_object_comes_back_also_after_an_error():
    machine, watch = Machine(), Stopwatch()

    def fail() -> None:
        raise ValueError("on purpose")

    machine.inner = fail  # type: ignore[method-assign]
    with pytest.raises(ValueError, match="on purpose"), watch.watching({"a": (machine, "inner")}):
        machine.inner()
    assert machine.inner is fail
    assert watch.seconds.keys() == {"a"}
