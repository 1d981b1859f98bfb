"""The stopwatch books time on the innermost part, and leaves no trace."""

import time

import pytest

from slider.bench.stopwatch import Stopwatch


def spin(seconds: float) -> None:
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


class Machine:
    def outer(self) -> str:
        spin(0.04)
        self.inner()
        return "done"

    def inner(self) -> None:
        spin(0.08)


def test_time_counts_for_the_part_that_spends_it():
    machine, watch = Machine(), Stopwatch()
    with watch.watching({"outer": (machine, "outer"), "inner": (machine, "inner")}):
        assert machine.outer() == "done"
    assert watch.seconds["outer"] == pytest.approx(0.04, abs=0.02)
    assert watch.seconds["inner"] == pytest.approx(0.08, abs=0.02)
    before = dict(watch.seconds)
    machine.outer()
    assert watch.seconds == before, "nothing is timed outside the block"
    assert not vars(machine)


def test_an_attribute_of_the_object_comes_back_also_after_an_error():
    machine, watch = Machine(), Stopwatch()

    def fail() -> None:
        raise ValueError("on purpose")

    machine.inner = fail  # type: ignore[method-assign]
    with pytest.raises(ValueError, match="on purpose"), watch.watching({"a": (machine, "inner")}):
        machine.inner()
    assert machine.inner is fail
    assert watch.seconds.keys() == {"a"}
