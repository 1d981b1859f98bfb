"""Time counts for the innermost part, and the methods come back."""

from collections import defaultdict

import pytest

from slider import bench
from slider.bench import timed


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
    machine, spent = Machine(), defaultdict(float)
    monkeypatch.setattr(bench, "time", machine)
    with timed({"outer": (machine, "outer"), "inner": (machine, "inner")}, spent):
        assert machine.outer() == "done"
    machine.outer()
    assert spent == {"outer": 5.0, "inner": 8.0}, "nothing is timed outside the block"
    assert vars(machine).keys() == {"_now"}


def test_attribute_comes_back_after_an_error():
    machine, spent = Machine(), defaultdict(float)

    def fail() -> None:
        raise ValueError("on purpose")

    machine.inner = fail  # type: ignore[method-assign]
    with pytest.raises(ValueError, match="on purpose"), timed({"a": (machine, "inner")}, spent):
        machine.inner()
    assert machine.inner is fail
    assert spent.keys() == {"a"}
