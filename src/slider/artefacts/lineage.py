"""Why jobs must run, and how two plans differ: a walk over the jobs of both."""

import json
from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Any

from slider.artefacts.current import recent_plans
from slider.artefacts.manifest import readable
from slider.artefacts.plan import JobSpec, Plan
from slider.artefacts.store import Store

NEVER = "never computed"
LOST = "object damaged or missing"
_WIDTH = 40  # characters of a value
_MISSING = object()


def differences(
    old: Plan, new: Plan, target: str, stores: tuple[Store, Store]
) -> dict[str, list[JobSpec]]:
    """Causes for which a target differs between two plans, with the jobs they affect directly.

    Jobs with the same recipe differ only if the ``stores`` of the plans hold different objects.
    """
    before, after = old.jobs_of(target), new.jobs_of(target)
    partners = _partners(before, after)
    causes: dict[str, list[JobSpec]] = {}
    differing: set[str] = set()
    for recipe, job in after.items():
        other = partners.get(recipe)
        if other is None:
            texts = [f"input {job.stage} added"]
        elif other.recipe != recipe:
            texts = _causes(other, job)
        else:
            paths = (store.manifest_path(job.stage, job.recipe) for store in stores)
            objects = {manifest.result.object for manifest in map(readable, paths) if manifest}
            first = differing.isdisjoint(item.recipe for item in job.needs)
            texts = ["other bytes of the same recipe"] if len(objects) == 2 and first else []
            differing |= {recipe} if len(objects) == 2 else set()
        for text in texts:
            causes.setdefault(text, []).append(job)
    for recipe in before.keys() - {job.recipe for job in partners.values()}:
        job = before[recipe]
        causes.setdefault(f"input {job.stage} removed", []).append(job)
    return causes


def _partners(old: Mapping[str, JobSpec], new: Mapping[str, JobSpec]) -> dict[str, JobSpec]:
    """Old counterpart of each new job, by the recipe of the new job.

    It has the same recipe, or else it is the next unmatched job with the same stage and label.
    """
    partners = {recipe: old[recipe] for recipe in new if recipe in old}
    left: dict[tuple[str, str], list[JobSpec]] = {}
    for recipe, job in old.items():
        if recipe not in new:
            left.setdefault((job.stage, job.label), []).append(job)
    for recipe, job in new.items():
        if recipe not in old and (others := left.get((job.stage, job.label))):
            partners[recipe] = others.pop(0)
    return partners


def pending(plan: Plan, target: str, store: Store) -> list[tuple[JobSpec, list[str]]]:
    """Jobs that a target needs and that lack an intact result, inputs first, with the reasons.

    They are compared with the jobs of the latest plan for which the target was computed.
    """
    needed, waiting = set[str](), [plan.jobs[plan.targets[target]]]
    while waiting:
        job = waiting.pop()
        if job.recipe not in needed and store.verify(job.stage, job.recipe) is None:
            needed.add(job.recipe)
            waiting += job.needs

    def was_computed(job: JobSpec | None) -> bool:
        return job is not None and store.manifest_path(job.stage, job.recipe).is_file()

    plans = (item for item in (plan, *recent_plans(store)) if target in item.targets)
    last = next((p for p in plans if was_computed(p.jobs[p.targets[target]])), plan)
    jobs = plan.jobs_of(target)
    partners = _partners(last.jobs_of(target), jobs)
    reasons = []
    for job in (job for recipe, job in jobs.items() if recipe in needed):
        before = partners.get(job.recipe)
        if before is None or before.recipe == job.recipe or not was_computed(before):
            reasons.append((job, [LOST if was_computed(job) else NEVER]))
            continue
        earlier = {item.recipe for item in before.needs}
        inputs = dict.fromkeys(item.stage for item in job.needs if item.recipe not in earlier)
        texts = [*_causes(before, job), *(f"input {stage}" for stage in inputs)]
        reasons.append((job, texts or ["fewer inputs"]))
    return reasons


def _causes(old: JobSpec, new: JobSpec) -> list[str]:
    """Differences between two jobs other than their inputs: settings, packages, then modules."""
    settings = _leaves(old.section, new.section)
    packages = _leaves(old.code.versions, new.code.versions, "package ")
    values = (f"{name} {_brief(a)} → {_brief(b)}" for name, a, b in chain(settings, packages))
    modules = _leaves(old.code.parts, new.code.parts, "source ")
    return [*values, *(f"{name} changed" for name, *_ in modules)]


def _brief(value: Any) -> str:
    if value is _MISSING:
        return "none"
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= _WIDTH else f"{text[: _WIDTH - 1]}…"


def _leaves(old: Any, new: Any, name: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Name, old and new value of each difference between two trees, in the order of the second."""
    if not isinstance(old, Mapping) or not isinstance(new, Mapping):
        if type(old) is not type(new) or old != new:
            yield name.removesuffix("."), old, new
        return
    for key in dict.fromkeys([*new, *old]):
        yield from _leaves(old.get(key, _MISSING), new.get(key, _MISSING), f"{name}{key}.")
    if {*old} == {*new} and [*old] != [*new]:  # the order of terms has a meaning
        yield f"{name}order", [*old], [*new]
