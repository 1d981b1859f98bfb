"""Processor time per part of a program, for methods that call each other."""

import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any


@contextmanager
def replaced(owner: object, name: str, function: Callable[..., Any]) -> Iterator[None]:
    """Put a function in the place of a method or a module's function until the block ends."""
    own = name in vars(owner)  # or of its class
    original = getattr(owner, name)
    setattr(owner, name, function)
    try:
        yield
    finally:
        if own:
            setattr(owner, name, original)
        else:
            delattr(owner, name)


class Stopwatch:
    """Adds up the processor time [s] of all threads; what a part calls counts for that part only.

    Attributes:
        seconds: time by part.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self._running: list[str] = []
        self._since = 0.0

    @contextmanager
    def watching(self, methods: Mapping[str, tuple[object, str]]) -> Iterator[None]:
        """Time methods, given as owner and name by part, until the block ends."""
        with ExitStack() as stack:
            for part, (owner, name) in methods.items():
                timed = self._timed(getattr(owner, name), part)
                stack.enter_context(replaced(owner, name, timed))
            yield

    def _timed(self, function: Callable[..., Any], part: str) -> Callable[..., Any]:
        def timed(*arguments: Any, **options: Any) -> Any:
            self._book()
            self._running.append(part)
            try:
                return function(*arguments, **options)
            finally:
                self._book()
                self._running.pop()

        vars(timed).update(getattr(function, "__dict__", {}))  # what a callable object knows
        return timed

    def _book(self) -> None:
        """Give the time since the last call to the innermost part that is running."""
        now = time.process_time()
        if self._running:
            self.seconds[self._running[-1]] += now - self._since
        self._since = now
