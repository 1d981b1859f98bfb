"""How much of a run is done and how long the rest takes, from the order in which jobs will start.

The rest is a schedule: of the jobs whose inputs are there the most urgent ones start, as many as
there are cores. So the forecast knows that a long job at the end leaves cores idle. Times are
expected ones, corrected by how much longer than expected the jobs of this run took.
"""

import heapq
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from graphlib import TopologicalSorter

_TRUST = 20.0  # seconds of finished jobs of a kind that weigh as much as the expectation
_ODD = 2.0  # a kind that deviates by more says no more of the others
_BRIEF = 5.0  # seconds of jobs of a kind that are too few to say anything
_TELLING = 0.1  # from this share done on, a job's own progress tells its rest
_OVERDUE = 0.2  # a job that runs longer than expected has this share of its time before it


@dataclass(frozen=True)
class Work:
    """One job of a run.

    Attributes:
        kind: jobs of a kind deviate alike from what was expected.
        seconds: expected wall time.
        inputs: recipes of the jobs that come before it.
        priority: the higher, the sooner it starts.
        threads: cores that it takes.
        uses: cores that it uses in the mean, some of them only where other jobs leave them idle.
    """

    kind: str
    seconds: float
    inputs: Sequence[str] = ()
    priority: float = 0.0
    threads: int = 1
    uses: float = 1.0


@dataclass
class Forecast:
    """The jobs of a run by recipe, and when they began and ended [s].

    Jobs that are inputs but not of the run are there already. ``shares`` holds of running jobs
    which part of them is done, 0 to 1, where they tell.
    """

    works: Mapping[str, Work]
    cores: int
    shares: dict[str, float] = field(default_factory=dict)
    _began: dict[str, float] = field(default_factory=dict)
    _took: dict[str, float] = field(default_factory=dict)
    _reused: set[str] = field(default_factory=set)
    _shown: float = 0.0

    @property
    def total(self) -> int:
        """Number of jobs of the run."""
        return len(self.works)

    @property
    def done(self) -> int:
        """Number of jobs that ended."""
        return len(self._took)

    @property
    def running(self) -> dict[str, float]:
        """Recipes of the jobs that run and when they began [s]."""
        return {r: began for r, began in self._began.items() if r not in self._took}

    def awaits(self, recipes: Iterable[str]) -> bool:
        """Tell whether any of some jobs is of the run and did not end."""
        return any(r in self.works and r not in self._took for r in recipes)

    def begin(self, recipe: str, now: float) -> None:
        """A job started."""
        self._began[recipe] = now

    def end(self, recipe: str, now: float, reused: bool = False) -> None:
        """A job ended; how long it took to find an earlier result says nothing of others."""
        self._took[recipe] = now - self._began.get(recipe, now)
        if reused or recipe not in self._began:
            self._reused.add(recipe)

    def share(self, now: float) -> float:
        """Done part of the work of the run, 0 to 1; never less than before."""
        pace = self._pace()
        before = sum(took * self.works[r].threads for r, took in self._took.items())
        after = 0.0
        for recipe, work in self.works.items():
            if recipe in self._took:
                continue
            before += (now - self._began.get(recipe, now)) * work.threads
            after += self._rest(recipe, now, pace) * work.threads
        self._shown = max(self._shown, before / (before + after) if before else 0.0)
        return 1.0 if self.done == self.total else min(self._shown, 0.999)

    def left(self, now: float) -> float:
        """Wall time until the last job ends [s]: of a schedule, and no less than the work takes."""
        pace = self._pace()
        work = sum(
            self._rest(recipe, now, pace) * self.works[recipe].uses
            for recipe in self.works.keys() - self._took.keys()
        )
        return max(self._scheduled(now, pace), work / self.cores)

    def _scheduled(self, now: float, pace: Mapping[str, float]) -> float:
        running = [(self._rest(recipe, now, pace), recipe) for recipe in self.running]
        heapq.heapify(running)
        free = self.cores - sum(self.works[recipe].threads for _, recipe in running)
        order = self._order()
        ready: list[tuple[float, str]] = []
        at = 0.0
        while True:
            for recipe in order.get_ready():
                if recipe not in self._began:
                    heapq.heappush(ready, (-self.works[recipe].priority, recipe))
            waiting = []
            while ready and free > 0:
                urgency, recipe = heapq.heappop(ready)
                threads = min(self.works[recipe].threads, self.cores)
                if threads > free:
                    waiting.append((urgency, recipe))
                    continue
                free -= threads
                heapq.heappush(running, (at + self._rest(recipe, now, pace), recipe))
            for item in waiting:
                heapq.heappush(ready, item)
            if not running:
                return at
            at, recipe = heapq.heappop(running)
            free += min(self.works[recipe].threads, self.cores)
            order.done(recipe)

    def _order(self) -> TopologicalSorter[str]:
        """The jobs that did not end, each after its inputs; those that run wait for none."""
        left = {r: work.inputs for r, work in self.works.items() if r not in self._took}
        order = TopologicalSorter(
            {r: () if r in self._began else left.keys() & inputs for r, inputs in left.items()}
        )
        order.prepare()
        return order

    def _pace(self) -> dict[str, float]:
        """Of each kind, how many times as long as expected its jobs take in this run.

        A kind that ran speaks for itself. For others the mean over kinds speaks of machine and
        load; one kind whose source has changed does not carry them away.
        """
        took: dict[str, float] = {}
        wanted: dict[str, float] = {}
        for recipe in self._took.keys() - self._reused:
            work = self.works[recipe]
            took[work.kind] = took.get(work.kind, 0.0) + self._took[recipe]
            wanted[work.kind] = wanted.get(work.kind, 0.0) + work.seconds
        logs = [
            math.log(min(max(took[kind] / wanted[kind], 1 / _ODD), _ODD))
            for kind in took
            if wanted[kind] > _BRIEF
        ]
        others = math.exp(sum(logs) / (len(logs) + 1))
        kinds = {work.kind for work in self.works.values()}
        return {
            kind: (took.get(kind, 0.0) + others * _TRUST) / (wanted.get(kind, 0.0) + _TRUST)
            for kind in kinds
        }

    def _rest(self, recipe: str, now: float, pace: Mapping[str, float]) -> float:
        """Expected wall time [s] that a job still takes; its own share done says more, if known."""
        work = self.works[recipe]
        elapsed = now - self._began.get(recipe, now)
        expected = max(work.seconds * pace[work.kind] - elapsed, _OVERDUE * elapsed)
        share = self.shares.get(recipe, 0.0)
        return elapsed * (1.0 - share) / share if share >= _TELLING else expected
