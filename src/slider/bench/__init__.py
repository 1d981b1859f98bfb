"""Measurements of speed, and what they share."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch


@contextmanager
def timed(methods: Mapping[str, tuple[object, str]], spent: dict[str, float]) -> Iterator[None]:
    """Add the processor time [s] of methods, given as owner and name by part, to ``spent``.

    Time of a method that another one calls counts for the inner part only.
    """
    running: list[tuple[str, float]] = []

    def wrapped(function: Callable[..., Any], part: str) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            start = time.process_time()
            running.append((part, 0.0))
            try:
                return function(*arguments, **options)
            finally:
                total = time.process_time() - start
                spent[part] += total - running.pop()[1]
                if running:
                    outer, inner = running[-1]
                    running[-1] = outer, inner + total

        vars(call).update(getattr(function, "__dict__", {}))  # attributes of a callable object
        return call

    with ExitStack() as stack:
        for part, (owner, name) in methods.items():
            function = wrapped(getattr(owner, name), part)
            stack.enter_context(patch.object(owner, name, function))
        yield
