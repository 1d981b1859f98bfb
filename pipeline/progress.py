"""What a person sees of a run: a line per finished job, one of the jobs that run long, tables."""

import re
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime

from pipeline.terminal import read_row, table
from slider.artefacts.forecast.reuse import reused_ahead
from slider.artefacts.forecast.schedule import Forecast, Work
from slider.artefacts.forecast.times import START, kind, times
from slider.artefacts.plan import JobSpec, Plan
from slider.artefacts.store import Store

_SILENCE = 20.0  # seconds without a line after which a running job is shown
_SHARE = re.compile(r"(\d+) ?(?:/|of) ?(\d+)|(\d+) %")  # what a job says of itself
_TABLE1 = "table1"


def _print(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


@dataclass
class Progress:
    """The lines of one run; Snakemake's scheduler tells when jobs begin and end.

    Attributes:
        plan: names the jobs.
        store: has their results and what they say of themselves.
        forecast: what is done and left.
        write: takes a line.
    """

    plan: Plan
    store: Store
    forecast: Forecast
    write: Callable[[str], None] = _print
    _start: float = field(default_factory=lambda: time.time())
    _said: float = field(default_factory=lambda: time.time())
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _over: threading.Event = field(default_factory=threading.Event)

    def open(self, cores: int) -> None:
        """Say how much there is to do, and look after long jobs from now on."""
        left = duration(self.forecast.left(time.time()))
        self.write(f"{self.forecast.total} jobs, about {left} on {cores} cores")
        threading.Thread(target=self._watch, daemon=True).start()

    def close(self, succeeded: bool = False) -> None:
        """Say no more of running jobs; after a success show Table 1 and where it is."""
        self._over.set()
        if succeeded and self._evaluations:
            self._show(self._evaluations)
            took = duration(time.time() - self._start)
            self.write(f"Table 1 took {took}: reports/table1.md has intervals and the paper's rows")

    def began(self, recipe: str) -> None:
        """A job started."""
        with self._lock:
            self.forecast.begin(recipe, time.time())

    def ended(self, recipe: str) -> None:
        """A job ended well."""
        job = self.plan.jobs[recipe]
        with self._lock:
            took = self._took(job)
            self.forecast.end(recipe, time.time(), reused=took is None)
            self._say(f"{job.label}: {'reused' if took is None else f'{took:.1f} s'}")
            self._show_policy(job)

    def _took(self, job: JobSpec) -> float | None:
        """Seconds of a computation of this run [s]; none where an earlier result was found."""
        began = self.forecast.running.get(job.recipe, self._start)
        facts = self.store.facts(job.stage, job.recipe)
        with suppress(ValueError, KeyError, TypeError):
            if facts["computed"] and datetime.fromisoformat(facts["ended"]).timestamp() > began:
                return float(facts["wall_s"])
        return None

    def _say(self, text: str) -> None:
        """A line with the jobs done, the share of the work and the time left."""
        now = self._said = time.time()
        self.forecast.shares = {r: share(self._message(r)) for r in self.forecast.running}
        done, total = self.forecast.done, self.forecast.total
        left = f"  about {duration(self.forecast.left(now))} left" if done < total else ""
        count = f"{done:>{len(str(total))}}/{total}"
        self.write(f"[{count}  {100 * self.forecast.share(now):3.0f} %{left}] {text}")

    def _watch(self) -> None:
        while not self._over.wait(1.0):
            with self._lock:
                if self.forecast.running and time.time() - self._said > _SILENCE:
                    self._say(self._running())

    def _running(self) -> str:
        """The most urgent of the running jobs, and how many others there are."""
        running = self.forecast.running
        recipe = min(running, key=lambda r: (-self.forecast.works[r].priority, running[r]))
        message = self._message(recipe) or f"{time.time() - running[recipe]:.0f} s so far"
        others = f"; {len(running) - 1} more" if len(running) > 1 else ""
        return f"{self.plan.jobs[recipe].label}: {message}{others}"

    def _message(self, recipe: str) -> str:
        path = self.store.progress_path(self.plan.jobs[recipe].stage, recipe)
        try:
            return path.read_text(encoding="utf-8", errors="replace").strip()
        except OSError:  # it has said nothing yet
            return ""

    @property
    def _evaluations(self) -> list[JobSpec]:
        """Those of Table 1, if this run makes it."""
        recipe = self.plan.targets.get(_TABLE1, "")
        if recipe not in self.forecast.works:
            return []
        return list(self.plan.jobs[recipe].inputs["evaluations"])

    def _show_policy(self, job: JobSpec) -> None:
        """The policy's part of Table 1 as soon as its last evaluation ends."""
        mine = [one for one in self._evaluations if one.stage == "evaluation"]
        others = len(self._evaluations) > len(mine)
        if others and job in mine and not self.forecast.awaits(one.recipe for one in mine):
            self._show(mine)

    def _show(self, evaluations: list[JobSpec]) -> None:
        labels = self.plan.jobs[self.plan.targets[_TABLE1]].section["labels"]
        found = [self.store.read_manifest(one.stage, one.recipe) for one in evaluations]
        self.write(table([read_row(labels, manifest.result.summary) for manifest in found]))


def forecast(
    plan: Plan, store: Store, needed: Mapping[str, tuple[float, int, int]], cores: int
) -> Forecast:
    """What the jobs of a run will take; one that an earlier result answers takes a moment.

    ``needed`` has priority, cores and threads with which Snakemake will run each recipe.
    """
    expected = times(store, sorted({plan.jobs[recipe].stage for recipe in needed}))
    known = reused_ahead(plan, store, needed.keys())
    works = {}
    for recipe, (priority, held, threads) in needed.items():
        job = plan.jobs[recipe]
        name, seconds, work = kind(job), expected.seconds(job, threads), expected.seconds(job)
        if recipe in known:
            name, seconds, work = "reused", START, START
        inputs = [item.recipe for item in job.needs]
        uses = work / seconds
        works[recipe] = Work(name, seconds, inputs, priority, min(held, cores), uses)
    return Forecast(works, cores)


def share(message: str) -> float:
    """Which part of it a job says that it has done, such as ``iteration 20/30`` or ``43 %``."""
    found = _SHARE.search(message.partition(",")[0])
    if not found:
        return 0.0
    done, total, percent = (float(text or 0) for text in found.groups())
    return min(done / total if total else percent / 100, 0.99)


def duration(seconds: float) -> str:
    """A time in the words of a person who waits."""
    if seconds < 60:
        return f"{max(5, 5 * round(seconds / 5))} s"
    if seconds < 90 * 60:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
