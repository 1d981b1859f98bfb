"""Lines of a run for people: one per finished job, one for jobs that run long, Table 1."""

import math
import re
import sys
import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from slider.artefacts.forecast import expected, latest_rates
from slider.artefacts.plan import Plan
from slider.artefacts.run_metadata import computed_seconds
from slider.artefacts.store import Store

_SILENCE = 20.0  # seconds without a line after which a running job is shown
_SHARE = re.compile(r"(\d+) ?(?:/|of) ?(\d+)|(\d+) %")  # in the message of a job
_TABLE1 = "table1"


def _print(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


class Progress:
    """The lines of one run, of some recipes of a plan; Snakemake tells when jobs begin and end."""

    def __init__(self, plan: Plan, store: Store, recipes: Iterable[str], cores: int) -> None:
        needed = set(recipes)
        self._jobs = {recipe: job for recipe, job in plan.jobs.items() if recipe in needed}
        rates = latest_rates(store, sorted({job.stage for job in self._jobs.values()}))
        self._seconds = {recipe: expected(job, rates) for recipe, job in self._jobs.items()}
        self._running: dict[str, float] = {}  # recipe → when it began [s]
        self._ended: dict[str, float] = {}
        self._plan, self._store, self._cores = plan, store, cores
        self._start = self._written = time.time()
        self._lock, self._closed = threading.Lock(), threading.Event()

    def open(self) -> None:
        """Write how much there is to do, and watch long jobs from now on."""
        _print(f"{len(self._jobs)} jobs, about {duration(self.left())} on {self._cores} cores")
        threading.Thread(target=self._watch, daemon=True).start()

    def close(self, succeeded: bool = False) -> None:
        """Stop writing; after a success show Table 1, if it was computed, and where it is."""
        self._closed.set()
        job = self._jobs.get(self._plan.targets.get(_TABLE1, ""))
        if succeeded and job is not None and job.recipe in self._ended:
            items = [(item.stage, item.recipe) for item in job.inputs["evaluations"]]
            summaries = [self._store.read_manifest(*item).result.summary for item in items]
            _print(table(job.section["labels"], summaries))
            took = duration(self._ended[job.recipe] - self._start)
            more = "reports/table1.md has intervals and the paper's rows"
            _print(f"Table 1 took {took}: {more}")

    def began(self, recipe: str) -> None:
        """A job started."""
        with self._lock:
            self._running[recipe] = time.time()

    def ended(self, recipe: str) -> None:
        """A job succeeded."""
        job = self._plan.jobs[recipe]
        with self._lock:
            began = self._running.pop(recipe, self._start)
            took = computed_seconds(self._store.metadata(job.stage, recipe), began)
            self._ended[recipe] = time.time()
            self._line(f"{job.label}: {'reused' if took is None else f'{took:.1f} s'}")

    def failed(self, recipe: str) -> None:
        """A job failed."""
        with self._lock:
            self._running.pop(recipe, None)

    def _line(self, text: str) -> None:
        """Write the jobs done, the share of the work, the time left, and a text."""
        now = self._written = time.time()
        done, total = len(self._ended), len(self._jobs)
        before = sum(self._seconds[recipe] for recipe in self._ended)
        before += sum(now - began for began in self._running.values())
        after = sum(self._rests())
        left = f"  about {duration(self.left())} left" if done < total else ""
        count = f"{done:>{len(str(total))}}/{total}"
        _print(f"[{count}  {100 * before / (before + after):3.0f} %{left}] {text}")

    def left(self) -> float:
        """Wall time until the last job ends [s], if all cores are busy until then."""
        rests = self._rests()
        return max(sum(rests) / self._cores, *rests, 0.0)

    def _rests(self) -> list[float]:
        """Wall time [s] that each job still takes, from its share done where it tells that."""
        now, rests = time.time(), []
        for recipe in self._jobs.keys() - self._ended.keys():
            elapsed = now - self._running.get(recipe, now)
            done = share(self._message(recipe)) if elapsed else 0.0
            expected = max(self._seconds[recipe] - elapsed, 0.2 * elapsed)
            rests.append(elapsed * (1.0 - done) / done if done else expected)
        return rests

    def _watch(self) -> None:
        while not self._closed.wait(1.0):
            with self._lock:
                if self._running and time.time() - self._written > _SILENCE:
                    self.show_running()

    def show_running(self) -> None:
        """Write the longest of the running jobs, and how many others there are."""
        running = self._running
        recipe = max(running, key=lambda recipe: self._seconds[recipe])
        message = self._message(recipe) or f"{time.time() - running[recipe]:.0f} s so far"
        others = f"; {len(running) - 1} more" if len(running) > 1 else ""
        self._line(f"{self._plan.jobs[recipe].label}: {message}{others}")

    def _message(self, recipe: str) -> str:
        path = self._store.progress_path(self._plan.jobs[recipe].stage, recipe)
        with suppress(OSError):  # the job has written nothing yet
            return path.read_text(encoding="utf-8", errors="replace").strip()
        return ""


def share(message: str) -> float:
    """Which part of it a job reports as done, such as ``iteration 20/30`` or ``43 %``."""
    match = _SHARE.search(message.partition(",")[0])
    if not match:
        return 0.0
    done, total, percent = (float(text or 0) for text in match.groups())
    return min(done / total if total else percent / 100, 0.99)


def duration(seconds: float) -> str:
    """A time as people say it."""
    if seconds < 60:
        return f"{max(5, 5 * round(seconds / 5))} s"
    if seconds < 90 * 60:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


def table(labels: Mapping[str, str], summaries: Sequence[Mapping[str, Any]]) -> str:
    """Success and error of evaluations, two lines per controller, a column per speed."""
    import pandas as pd

    from slider.reports.quantities import QUANTITIES

    cells = {(summary["controller"], summary["speed"]): summary for summary in summaries}
    speeds = sorted({summary["speed"] for summary in summaries})
    rows = []
    for controller in dict.fromkeys(summary["controller"] for summary in summaries):
        for name, title in (("success_rate", "success [%]"), ("mse_steady", "MSE [m²/s²]")):
            values = [cells.get((controller, speed), {}).get(name, math.nan) for speed in speeds]
            texts = [QUANTITIES[name].text(math.inf if v is None else v) for v in values]
            rows.append([labels.get(controller, controller), title, *texts])
    return pd.DataFrame(rows, columns=["speed [m/s]", "", *speeds]).to_string(index=False)
