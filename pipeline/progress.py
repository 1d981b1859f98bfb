"""Progress lines of a run: one per finished job, one for long-running jobs, and Table 1."""

import math
import sys
import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from slider.artefacts.forecast import expected, known_rates
from slider.artefacts.plan import Plan
from slider.artefacts.run_metadata import computed_seconds
from slider.artefacts.store import Store

_SILENCE = 20.0  # seconds without a line after which a running job is shown
_SHOWN = {
    "success_rate": "success [%]",
    "tracking_rate": "tracking [%]",
    "mse_steady": "MSE [m²/s²]",
}


def _print(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


class Progress:
    """Progress lines of the jobs of a run; ``began`` and ``ended`` are called for each job."""

    def __init__(self, plan: Plan, store: Store, recipes: Iterable[str], cores: int) -> None:
        needed = set(recipes)
        self._jobs = {recipe: job for recipe, job in plan.jobs.items() if recipe in needed}
        rates = known_rates(store, sorted({job.stage for job in self._jobs.values()}))
        self._seconds = {recipe: expected(job, rates) for recipe, job in self._jobs.items()}
        self._running: dict[str, float] = {}  # recipe → when it began [s]
        self._ended: set[str] = set()
        self._plan, self._store, self._cores = plan, store, cores
        self._start = self._written = time.time()
        self._lock, self._closed = threading.Lock(), threading.Event()

    def open(self) -> None:
        """Write the number of jobs and the expected time, and start to watch long jobs."""
        _print(f"{len(self._jobs)} jobs, about {duration(self.left())} on {self._cores} cores")
        threading.Thread(target=self._watch, daemon=True).start()

    def close(self) -> None:
        """Stop writing."""
        self._closed.set()

    def began(self, recipe: str) -> None:
        """Note the start of a job."""
        with self._lock:
            self._running[recipe] = time.time()

    def ended(self, recipe: str, succeeded: bool = True) -> None:
        """Note the end of a job; write a line if it succeeded."""
        job = self._plan.jobs[recipe]
        with self._lock:
            began = self._running.pop(recipe, self._start)
            if not succeeded:
                return
            took = computed_seconds(self._store.metadata(job.stage, recipe), began)
            self._ended.add(recipe)
            self._line(f"{job.label}: {'reused' if took is None else f'{took:.1f} s'}")
        if job.stage == "table1":
            items = [(item.stage, item.recipe) for item in job.inputs["evaluations"]]
            summaries = [self._store.read_manifest(*item).result.summary for item in items]
            _print(table(job.section["labels"], summaries))
            _print("reports/table1.md has the intervals")

    def _line(self, text: str) -> None:
        """Write the number of finished jobs, the remaining time, and a text."""
        self._written = time.time()
        done, total = len(self._ended), len(self._jobs)
        left = f"  about {duration(self.left())} left" if done < total else ""
        _print(f"[{done:>{len(str(total))}}/{total}{left}] {text}")

    def left(self) -> float:
        """Wall time until the last job ends [s], if all cores are busy until then."""
        now, rests = time.time(), [0.0]
        for recipe in self._jobs.keys() - self._ended:
            passed = now - self._running.get(recipe, now)  # overdue: expect a fifth of it more
            rests.append(max(self._seconds[recipe] - passed, 0.2 * passed))
        return max(sum(rests) / self._cores, *rests)

    def _watch(self) -> None:
        while not self._closed.wait(1.0):
            with self._lock:
                if self._running and time.time() - self._written > _SILENCE:
                    self.show_running()

    def show_running(self) -> None:
        """Write a line about the longest running job and the number of other running jobs."""
        running = self._running
        recipe = max(running, key=lambda recipe: self._seconds[recipe])
        job, message = self._plan.jobs[recipe], ""
        with suppress(OSError):  # the job has written nothing yet
            note = self._store.progress_path(job.stage, recipe)
            message = note.read_text(encoding="utf-8", errors="replace").strip()
        message = message or f"{time.time() - running[recipe]:.0f} s so far"
        others = f"; {len(running) - 1} more" if len(running) > 1 else ""
        self._line(f"{job.label}: {message}{others}")


def duration(seconds: float) -> str:
    """Duration as text."""
    if seconds < 60:
        return f"{max(5, 5 * round(seconds / 5))} s"
    if seconds < 90 * 60:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


def table(labels: Mapping[str, str], summaries: Sequence[Mapping[str, Any]]) -> str:
    """Table of success, tracking and error of evaluations, with a column per speed."""
    import pandas as pd

    from slider.reports.quantities import QUANTITIES

    cells = {(summary["controller"], summary["speed"]): summary for summary in summaries}
    speeds = sorted({summary["speed"] for summary in summaries})
    rows = []
    for controller in dict.fromkeys(summary["controller"] for summary in summaries):
        for name, title in _SHOWN.items():
            values = [cells.get((controller, speed), {}).get(name, math.nan) for speed in speeds]
            texts = [QUANTITIES[name].text(math.inf if v is None else v) for v in values]
            rows.append([labels.get(controller, controller), title, *texts])
    return pd.DataFrame(rows, columns=["speed [m/s]", "", *speeds]).to_string(index=False)
