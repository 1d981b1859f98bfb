"""Bridge from rsl-rl's scalars to the tracker and to the learning curve, a batch per iteration."""

from rsl_rl.utils.log_writer import LogWriter

from slider.core.job import Tracker

# rsl-rl logs these against the wall clock instead of the iteration.
_SKIPPED_SUFFIX = "/time"
_VOLATILE = "Perf/"  # times and rates: no part of a result
ITERATION = "iteration"


class TrackerLogWriter(LogWriter):
    """Collects the scalars of an iteration and hands them over together.

    Args:
        tracker: gets all of them.
        curve: gets a row per iteration with what does not depend on the machine's speed.
    """

    def __init__(self, tracker: Tracker, curve: list[dict[str, float]]) -> None:
        self._tracker, self._curve = tracker, curve
        self._step = 0
        self._metrics: dict[str, float] = {}

    def add_scalar(self, tag: str, scalar_value: float, global_step: int) -> None:
        """Note one scalar; a new step flushes the last one."""
        if tag.endswith(_SKIPPED_SUFFIX):
            return
        if global_step != self._step:
            self._flush()
            self._step = global_step
        self._metrics[tag.strip("/")] = float(scalar_value)

    def stop(self) -> None:
        """Flush what is left."""
        self._flush()

    def _flush(self) -> None:
        if self._metrics:
            self._tracker.log_metrics(self._metrics, self._step)
            lasting = {k: v for k, v in self._metrics.items() if not k.startswith(_VOLATILE)}
            self._curve.append({ITERATION: self._step, **lasting})
        self._metrics = {}
