"""Lines of a run for people: one per finished job, one for jobs that run long, Table 1."""

import math
import re
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from slider.artefacts.forecast import START, Forecast, Work, expected, remembered, reused_ahead
from slider.artefacts.plan import JobSpec, Plan
from slider.artefacts.store import Store

_SILENCE = 20.0  # seconds without a line after which a running job is shown
_SHARE = re.compile(r"(\d+) ?(?:/|of) ?(\d+)|(\d+) %")  # in the message of a job
_TABLE1 = "table1"


def _print(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


@dataclass
class Progress:
    """The lines of one run; Snakemake's scheduler tells when jobs begin and end.

    Attributes:
        plan: names the jobs.
        store: has their results and messages.
        forecast: what is done and left.
        write: takes a line.
    """

    plan: Plan
    store: Store
    forecast: Forecast
    write: Callable[[str], None] = _print
    _start: float = field(default_factory=lambda: time.time())
    _written: float = field(default_factory=lambda: time.time())
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _closed: threading.Event = field(default_factory=threading.Event)

    def open(self) -> None:
        """Write how much there is to do, and watch long jobs from now on."""
        left = duration(self.forecast.left(time.time()))
        jobs, cores = len(self.forecast.works), self.forecast.cores
        self.write(f"{jobs} jobs, about {left} on {cores} cores")
        threading.Thread(target=self._watch, daemon=True).start()

    def close(self, succeeded: bool = False) -> None:
        """Stop writing; after a success show Table 1 and where it is."""
        self._closed.set()
        if succeeded and self._evaluations:
            self._show(self._evaluations)
            took = duration(time.time() - self._start)
            self.write(f"Table 1 took {took}: reports/table1.md has intervals and the paper's rows")

    def began(self, recipe: str) -> None:
        """A job started."""
        with self._lock:
            self.forecast.begin(recipe, time.time())

    def ended(self, recipe: str) -> None:
        """A job succeeded."""
        job = self.plan.jobs[recipe]
        with self._lock:
            took = self._took(job)
            self.forecast.end(recipe, time.time(), reused=took is None)
            self._line(f"{job.label}: {'reused' if took is None else f'{took:.1f} s'}")
            self._show_policy(job)

    def _took(self, job: JobSpec) -> float | None:
        """Seconds of a computation of this run [s]; none where an earlier result was reused."""
        began = self.forecast.running.get(job.recipe, self._start)
        facts = self.store.facts(job.stage, job.recipe)
        with suppress(ValueError, KeyError, TypeError):
            if facts["computed"] and datetime.fromisoformat(facts["ended"]).timestamp() > began:
                return float(facts["wall_s"])
        return None

    def _line(self, text: str) -> None:
        """Write the jobs done, the share of the work, the time left, and a text."""
        now = self._written = time.time()
        self.forecast.shares = {r: share(self._message(r)) for r in self.forecast.running}
        done, total = len(self.forecast.ended), len(self.forecast.works)
        left = f"  about {duration(self.forecast.left(now))} left" if done < total else ""
        count = f"{done:>{len(str(total))}}/{total}"
        self.write(f"[{count}  {100 * self.forecast.share(now):3.0f} %{left}] {text}")

    def _watch(self) -> None:
        while not self._closed.wait(1.0):
            with self._lock:
                if self.forecast.running and time.time() - self._written > _SILENCE:
                    self._line(self._running())

    def _running(self) -> str:
        """The most urgent of the running jobs, and how many others there are."""
        running = self.forecast.running
        recipe = min(running, key=lambda r: (-self.forecast.works[r].priority, running[r]))
        message = self._message(recipe) or f"{time.time() - running[recipe]:.0f} s so far"
        others = f"; {len(running) - 1} more" if len(running) > 1 else ""
        return f"{self.plan.jobs[recipe].label}: {message}{others}"

    def _message(self, recipe: str) -> str:
        path = self.store.progress_path(self.plan.jobs[recipe].stage, recipe)
        with suppress(OSError):  # the job has written nothing yet
            return path.read_text(encoding="utf-8", errors="replace").strip()
        return ""

    @property
    def _evaluations(self) -> list[JobSpec]:
        """Those of Table 1, if this run computes it."""
        recipe = self.plan.targets.get(_TABLE1, "")
        if recipe not in self.forecast.works:
            return []
        return list(self.plan.jobs[recipe].inputs["evaluations"])

    def _show_policy(self, job: JobSpec) -> None:
        """Show the policy's part of Table 1 as soon as its last evaluation ends."""
        policy = [item for item in self._evaluations if item.stage == "evaluation"]
        others = len(self._evaluations) > len(policy)
        left = self.forecast.works.keys() - self.forecast.ended.keys()
        if others and job in policy and not any(item.recipe in left for item in policy):
            self._show(policy)

    def _show(self, evaluations: list[JobSpec]) -> None:
        labels = self.plan.jobs[self.plan.targets[_TABLE1]].section["labels"]
        manifests = [self.store.read_manifest(item.stage, item.recipe) for item in evaluations]
        self.write(table(labels, [manifest.result.summary for manifest in manifests]))


def forecast(
    plan: Plan, store: Store, needed: Mapping[str, tuple[float, int]], cores: int
) -> Forecast:
    """Expected times of the jobs of a run; one that an earlier result answers takes a moment.

    ``needed`` has priority and cores with which Snakemake will run each recipe.
    """
    rates = remembered(store, sorted({plan.jobs[recipe].stage for recipe in needed}))
    reused = reused_ahead(plan, store, needed.keys())
    works = {}
    for recipe, (priority, threads) in needed.items():
        job = plan.jobs[recipe]
        seconds = START if recipe in reused else expected(job, rates)
        works[recipe] = Work(seconds, [item.recipe for item in job.needs], priority, threads)
    return Forecast(works, cores)


def share(message: str) -> float:
    """Which part of it a job reports as done, such as ``iteration 20/30`` or ``43 %``."""
    match = _SHARE.search(message.partition(",")[0])
    if not match:
        return 0.0
    done, total, percent = (float(text or 0) for text in match.groups())
    return min(done / total if total else percent / 100, 0.99)


def duration(seconds: float) -> str:
    """A time in the words of a person who waits."""
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
