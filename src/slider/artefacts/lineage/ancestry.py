"""A result and all that it was made from, jobs of one stage together."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from slider.artefacts.lineage.targets import Found, manifest_of
from slider.artefacts.plan import JobSpec, build_plan
from slider.artefacts.source.parts import known_parts
from slider.artefacts.store import Manifest, Result, Store


@dataclass(frozen=True)
class Made:
    """A job, its manifest if it has a result, and what is noted beside that."""

    job: JobSpec
    manifest: Manifest | None
    facts: Mapping[str, Any]

    @property
    def result(self) -> Result:
        """Result of a job that has one."""
        assert self.manifest is not None
        return self.manifest.result


@dataclass(frozen=True)
class Step:
    """Jobs of one stage that are inputs of the same jobs, and the steps before them.

    ``known`` says that an earlier step of the tree has the same jobs, with what is before them.
    """

    stage: str
    made: tuple[Made, ...]
    inputs: list["Step"] = field(default_factory=list)
    known: bool = False


def made(store: Store, job: JobSpec) -> Made:
    """A job with its manifest and facts."""
    return Made(job, manifest_of(store, job), store.facts(job.stage, job.recipe))


def steps(found: Found) -> Step:
    """Tree of the stages behind a result."""
    return _step(found.store, [found.job], set())


def _step(store: Store, jobs: Sequence[JobSpec], seen: set[frozenset[str]]) -> Step:
    recipes = frozenset(job.recipe for job in jobs)
    own = tuple(made(store, job) for job in jobs)
    if recipes in seen:
        return Step(jobs[0].stage, own, known=True)
    seen.add(recipes)
    groups: dict[str, dict[str, JobSpec]] = {}
    for item in (item for job in jobs for group in job.inputs.values() for item in group):
        groups.setdefault(item.stage, {})[item.recipe] = item
    inputs = [_step(store, [*group.values()], seen) for group in groups.values()]
    return Step(jobs[0].stage, own, inputs)


def everything(found: Found) -> dict[str, Any]:
    """All that is known of a result, and its ancestors by recipe, as plain values."""
    one = made(found.store, found.job)
    jobs = build_plan({found.name: found.job}).jobs.values()
    return {
        "name": found.name,
        **_plain(one),
        "files": one.manifest.result.files if one.manifest else {},
        "summary": one.manifest.result.summary if one.manifest else {},
        "configuration": dict(found.job.section),
        "code": asdict(found.job.code),
        "modules": known_parts(found.store, found.job.code.source),
        "jobs": {job.recipe: _plain(made(found.store, job)) for job in jobs},
    }


def _plain(one: Made) -> dict[str, Any]:
    return {
        "stage": one.job.stage,
        "label": one.job.label,
        "recipe": one.job.recipe,
        "object": one.manifest.result.object if one.manifest else None,
        "resumed": bool(one.manifest and one.manifest.result.resumed),
        "noted": dict(one.facts),
        "inputs": one.job.input_recipes,
    }
