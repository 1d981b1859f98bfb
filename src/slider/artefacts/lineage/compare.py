"""Two results beside each other: the root causes of their difference, inputs first."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from slider.artefacts.lineage.causes import Cause, Comparison, pairs
from slider.artefacts.lineage.targets import Found
from slider.artefacts.plan import JobSpec
from slider.core import files

_OF_A_RUN = {
    *("computed", "dirty", "overrides", "reused_from", "taken_from", "waiting"),
    *("started", "ended"),
}
"""Facts that differ between any two runs, or that the recipe already answers for."""


@dataclass(frozen=True)
class Difference:
    """A cause, and the jobs that depend on it directly; of an input the inputs themselves."""

    cause: Cause
    jobs: tuple[JobSpec, ...]


def compare(old: Found, new: Found) -> list[Difference]:
    """Root causes of the difference of two jobs, in the order from the first input to them.

    Jobs of the same recipe differ only if their results do: then it is said what is noted of how
    they were computed.
    """
    return _Walk(old, new).differences()


class _Walk:
    """Goes through pairs of jobs and collects causes; each pair once."""

    def __init__(self, old: Found, new: Found) -> None:
        self._old, self._new = old, new
        self._comparison = Comparison(old.plan, new.plan)
        self._found: dict[Cause, dict[str, JobSpec]] = {}
        self._seen: set[tuple[str, str]] = set()
        self._other: dict[str, bool] = {}

    def differences(self) -> list[Difference]:
        self._visit(self._old.job, self._new.job)
        found = [Difference(cause, tuple(jobs.values())) for cause, jobs in self._found.items()]
        jobs = tuple(job for one in found if one.cause.kind == "input" for job in one.jobs)
        shaping = self._comparison.shaping() if jobs else []
        return [*(Difference(cause, jobs) for cause in shaping), *found]

    def _visit(self, old: JobSpec, new: JobSpec) -> None:
        if (old.recipe, new.recipe) in self._seen:
            return
        self._seen.add((old.recipe, new.recipe))
        if old.recipe == new.recipe:
            self._has_other_bytes(new)
            return
        own = self._comparison.own(old, new)
        for before, after in pairs(old, new) if old.stage == new.stage else ():
            if before and after:
                self._visit(before, after)
            elif job := before or after:
                facts = (job.stage, None) if before else (None, job.stage)
                self._note(Cause("input", job.stage, *facts), job)
        for cause in own:
            self._note(cause, new)

    def _note(self, cause: Cause, job: JobSpec) -> None:
        self._found.setdefault(cause, {})[job.recipe] = job

    def _has_other_bytes(self, job: JobSpec) -> bool:
        """Tell whether the results of one recipe differ; note where that begins."""
        if job.recipe not in self._other:
            self._other[job.recipe] = self._begins(job)
        return self._other[job.recipe]

    def _begins(self, job: JobSpec) -> bool:
        sides = [Found(side.store, side.plan, job) for side in (self._old, self._new)]
        if None in (objects := {side.object for side in sides}) or len(objects) == 1:
            return False
        earlier = [self._has_other_bytes(item) for item in job.needs]  # all, not the first alone
        if not any(earlier):
            old, new = map(_noted, sides)
            for name in [n for n in {**old, **new} if old.get(n) != new.get(n)] or [""]:
                values = [files.canonical(facts.get(name)) for facts in (old, new)]
                self._note(Cause("circumstance", name, *values), job)
        return True


def _noted(side: Found) -> Mapping[str, Any]:
    """What is the same in two runs of one job under the same circumstances."""
    measured = ("_s", "_at_start", "_started")
    facts = {k: v for k, v in side.facts.items() if not k.endswith(measured)}
    resumed = side.manifest is not None and side.manifest.result.resumed
    return {k: v for k, v in facts.items() if k not in _OF_A_RUN} | {"resumed": resumed}
