"""How much of a run is done, and how long the rest takes.

A job takes as long as earlier ones of its kind, in proportion to its size, or as in a table that
ships. What is left is a schedule: jobs whose inputs are there start in their order, as many as
there are cores.
"""

import csv
import heapq
import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from importlib.resources import files as package_files
from itertools import islice
from typing import Any

from slider.artefacts.plan import JobSpec
from slider.artefacts.store import Store
from slider.core import files

START = 0.7
"""Seconds from Snakemake's decision to the first line of a job: a Python process."""
TABLE = "times.csv"
_UNKNOWN = 5.0  # seconds of a job of an unknown kind
_LATEST = 64  # remembered jobs of a stage
_TRUST = 20.0  # seconds of finished jobs that weigh as much as the expectation
_TRAINING = ("train.robots", "train.steps_per_iteration", "train.iterations")
_EVALUATION = ("evaluation.trials", "evaluation.robots", "evaluation.duration")
_GAUGE = tuple(f"protocol.{name}" for name in ("trials", "speeds", "robots", "duration"))
_FACTORS = {
    **dict.fromkeys(("gait", "gait_start"), ("formulation.nodes",)),
    **dict.fromkeys(("stability_gaits", "return_maps", "verification_gaits"), ("velocities",)),
    **dict.fromkeys(("standing", "walking"), _TRAINING),
    **dict.fromkeys(("evaluation", "baseline"), _EVALUATION),
    "gauge_axis": (*_GAUGE, "values", "directions"),
    "gait_walks": ("steps",),
    "video": ("video.duration",),
}
"""Stage → values of its section that its time is in proportion to; of a list, its length."""
Rates = Mapping[str, Sequence[float]]
"""Kind → seconds per size of its jobs."""


def kind(job: JobSpec) -> str:
    """Stage of a job, and the controller that it evaluates."""
    return " ".join(filter(None, (job.stage, job.section.get("controller"))))


def size(job: JobSpec) -> float:
    """Product of the values that the time of a job is in proportion to."""
    factors = []
    for key in _FACTORS.get(job.stage, ()):
        value: Any = job.section
        for part in key.split("."):
            value = value.get(part) if isinstance(value, Mapping) else None
        value = len(value) if isinstance(value, list) else value
        factors.append(value if isinstance(value, int | float) else 1.0)
    return math.prod(factors)


def computed(
    store: Store, stages: Iterable[str], latest: int | None = None
) -> dict[str, list[tuple[float, float]]]:
    """Processor seconds and seconds per size of the (latest) jobs of some stages, by kind."""
    jobs: dict[str, list[tuple[float, float]]] = {}
    for stage in stages:
        paths = store.root.glob(f"{stage}/*.run.json")
        for path in sorted(paths, key=lambda path: -path.stat().st_mtime)[:latest]:
            with suppress(OSError, ValueError, KeyError, TypeError):
                facts = files.read_json(path)
                if facts["computed"] and facts["size"]:
                    spent = float(facts["cpu_s"])
                    rate = min(facts["wall_s"], spent) / facts["size"]
                    jobs.setdefault(facts["kind"], []).append((spent, rate))
    return jobs


def remembered(store: Store, stages: Iterable[str]) -> Rates:
    """Processor seconds per size of the latest jobs of some stages.

    A kind without any has the rate of the table that ships, which ``slider store times`` writes.
    """
    with package_files("slider.artefacts").joinpath(TABLE).open(encoding="utf-8") as file:
        rates = {row["kind"]: [float(row["rate"])] for row in csv.DictReader(file)}
    jobs = computed(store, stages, _LATEST)
    return rates | {kind: [rate for _, rate in latest] for kind, latest in jobs.items()}


def expected(job: JobSpec, rates: Rates) -> float:
    """Expected wall time of a job [s], start of its process included."""
    earlier = rates.get(kind(job))
    return START + (statistics.median(earlier) * size(job) if earlier else _UNKNOWN)


@dataclass
class Forecast:
    """The jobs of a run by recipe, and when they began and ended [s].

    Jobs are in an order with inputs first; what they need besides is there already. ``seconds`` are
    their expected wall times on a core each, ``shares`` the parts of running jobs that are done,
    0 to 1, where these tell.
    """

    jobs: Mapping[str, JobSpec]
    seconds: Mapping[str, float]
    cores: int
    shares: dict[str, float] = field(default_factory=dict)
    began: dict[str, float] = field(default_factory=dict)
    ended: dict[str, float] = field(default_factory=dict)
    _computed: dict[str, float] = field(default_factory=dict)

    @property
    def running(self) -> dict[str, float]:
        """Recipes of the jobs that run and when they began [s]."""
        return {r: began for r, began in self.began.items() if r not in self.ended}

    def end(self, recipe: str, now: float, reused: bool = False) -> None:
        """A job ended; the time of one that reused a result tells nothing about others."""
        self.ended[recipe] = now
        if recipe in self.began and not reused:
            self._computed[recipe] = now - self.began[recipe]

    def share(self, now: float) -> float:
        """Done part of the work of the run, 0 to 1."""
        before = sum(self.seconds[recipe] for recipe in self.ended)
        before += sum(now - began for began in self.running.values())
        after = sum(self._rest(recipe, now) for recipe in self.jobs if recipe not in self.ended)
        return before / (before + after) if before + after else 1.0

    def left(self, now: float) -> float:
        """Wall time until the last job ends [s], if jobs start as soon as they can."""
        left = self.jobs.keys() - self.ended.keys()
        running = [(self._rest(recipe, now), recipe) for recipe in self.running]
        heapq.heapify(running)
        waiting = {
            recipe: {item.recipe for item in job.needs} & left
            for recipe, job in self.jobs.items()
            if recipe in left - self.began.keys()
        }
        at = 0.0
        while waiting or running:
            ready = (recipe for recipe, inputs in waiting.items() if not inputs)
            for recipe in [*islice(ready, max(0, self.cores - len(running)))]:
                del waiting[recipe]
                heapq.heappush(running, (at + self._rest(recipe, now), recipe))
            at, ended = heapq.heappop(running)
            for inputs in waiting.values():
                inputs.discard(ended)
        return at

    def _rest(self, recipe: str, now: float) -> float:
        """Wall time [s] that a job still takes, from its share done where it tells that."""
        elapsed = now - self.began.get(recipe, now)
        share = self.shares.get(recipe, 0.0)
        if share:
            return elapsed * (1.0 - share) / share
        took = sum(self._computed.values()) + _TRUST
        pace = took / (sum(self.seconds[r] for r in self._computed) + _TRUST)
        return max(self.seconds[recipe] * pace - elapsed, 0.2 * elapsed)
