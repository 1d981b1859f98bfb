"""Two results beside each other: the root causes of their difference, inputs first."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from slider.artefacts.lineage.causes import Cause, Comparison, PartsOf, pairs
from slider.artefacts.lineage.targets import Found, manifest_of
from slider.artefacts.plan import JobSpec
from slider.artefacts.source.parts import Parts, known_parts
from slider.artefacts.store import Store
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


def compare(old: Found, new: Found, noted: Sequence[Store] = ()) -> list[Difference]:
    """Root causes of the difference of two jobs, in the order from the first input to them.

    Jobs of the same recipe differ only if their results do: then it is said what is noted of how
    they were computed.

    Args:
        old: one job.
        new: the other.
        noted: further stores that know the modules of a source digest.
    """
    return _Walk(old, new, parts_in(old.store, new.store, *noted)).differences()


def parts_in(*stores: Store) -> PartsOf:
    """Function that gives the modules of a source digest, if one of the stores has them."""

    @cache
    def find(source: str) -> Parts | None:
        return next(filter(None, (known_parts(store, source) for store in stores)), None)

    return find


class _Walk:
    """Goes through pairs of jobs and collects causes; each pair once."""

    def __init__(self, old: Found, new: Found, parts: PartsOf) -> None:
        self._old, self._new = old, new
        self._comparison = Comparison(old.plan, new.plan, parts)
        self._found: dict[Cause, dict[str, JobSpec]] = {}
        self._seen: set[tuple[str, str]] = set()
        self._other: dict[str, bool] = {}

    def differences(self) -> list[Difference]:
        self._visit(self._old.job, self._new.job)
        found = [Difference(cause, tuple(jobs.values())) for cause, jobs in self._found.items()]
        inputs = [one for one in found if one.cause.kind == "input"]
        jobs = tuple(job for one in inputs for job in one.jobs)
        shaping = self._comparison.shaping() if inputs else []
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
        stores = self._old.store, self._new.store
        old, new = (manifest_of(store, job) for store in stores)
        if old is None or new is None or old.result.object == new.result.object:
            return False
        inputs = [item for group in job.inputs.values() for item in group]
        earlier = [self._has_other_bytes(item) for item in inputs]  # all, not the first alone
        if any(earlier):
            return True
        noted = [
            _noted(store.facts(job.stage, job.recipe)) | {"resumed": manifest.result.resumed}
            for store, manifest in zip(stores, (old, new), strict=True)
        ]
        names = [n for n in {**noted[0], **noted[1]} if noted[0].get(n) != noted[1].get(n)]
        for name in names or [""]:
            values = [files.canonical(facts.get(name)) for facts in noted]
            self._note(Cause("circumstance", name, *values), job)
        return True


def _noted(facts: Mapping[str, Any]) -> dict[str, Any]:
    """What is the same in two runs of one job under the same circumstances."""
    measured = ("_s", "_at_start", "_started")
    return {k: v for k, v in facts.items() if k not in _OF_A_RUN and not k.endswith(measured)}
