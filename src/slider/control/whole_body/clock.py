"""Processor time of the parts of a control tick; for display, never part of a result."""

import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager


class TickClock:
    """Adds up the processor time of named parts over robots and ticks."""

    def __init__(self) -> None:
        self.ticks = 0
        self._seconds: dict[str, float] = defaultdict(float)

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Time what runs inside; parts are not nested."""
        start = time.process_time()
        yield
        self._seconds[name] += time.process_time() - start

    def microseconds(self) -> dict[str, float]:
        """Mean processor time per robot and tick of each part [µs]."""
        ticks = max(self.ticks, 1)
        return {name: round(1e6 * value / ticks, 2) for name, value in self._seconds.items()}
