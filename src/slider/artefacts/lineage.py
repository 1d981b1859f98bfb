"""Why jobs must run, and how two plans differ: a walk over the jobs of both."""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from slider.artefacts.current import recent_plans
from slider.artefacts.manifest import readable
from slider.artefacts.plan import JobSpec, Plan
from slider.artefacts.store import Store

NEVER = "never computed"
LOST = "object damaged or missing"
_WIDTH = 40  # characters of a value
_ABSENT = object()
Leaf = tuple[tuple[str, ...], Any, Any]
"""Path of a value that differs, before, after."""


def differences(
    old: Plan, new: Plan, target: str, stores: tuple[Store, Store]
) -> dict[str, list[JobSpec]]:
    """Causes of the difference of a target in two plans, with the jobs that they act on directly.

    Jobs of one recipe differ only where the ``stores`` of the plans hold other objects of it.
    """
    before, after = old.jobs_of(target), new.jobs_of(target)
    partners, keys = _partners(before, after), _configuration_changes(old, new)
    causes: dict[str, list[JobSpec]] = {}
    differing: set[str] = set()
    for recipe, job in after.items():
        other = partners.get(recipe)
        if other is None:
            texts = [f"input {job.stage} added"]
        elif other.recipe != recipe:
            texts = _causes(other, job, keys)
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
    """Old job in the place of each new one, by the latter's recipe.

    It has the same recipe, or else is the next one of the same stage and label.
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
    """Jobs without a whole result that lead to a target, inputs first, each with its reasons.

    They are compared with those of the latest plan in which the target was computed.
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
    jobs, keys = plan.jobs_of(target), _configuration_changes(last, plan)
    partners = _partners(last.jobs_of(target), jobs)
    reasons = []
    for job in (job for recipe, job in jobs.items() if recipe in needed):
        before = partners.get(job.recipe)
        if before is None or before.recipe == job.recipe or not was_computed(before):
            reasons.append((job, [LOST if was_computed(job) else NEVER]))
            continue
        earlier = {item.recipe for item in before.needs}
        inputs = dict.fromkeys(item.stage for item in job.needs if item.recipe not in earlier)
        texts = [*_causes(before, job, keys), *(f"input {stage}" for stage in inputs)]
        reasons.append((job, texts or ["fewer inputs"]))
    return reasons


def _configuration_changes(old: Plan, new: Plan) -> list[Leaf]:
    """Keys that people set and that differ: the page, a job of both plans, shows them all."""
    trees = []
    for plan in (old, new):
        page = plan.jobs.get(plan.targets.get("report", ""))
        trees.append(page.section.get("configuration", {}) if page else {})
    return list(_leaves(*trees))


def _causes(old: JobSpec, new: JobSpec, keys: Sequence[Leaf]) -> list[str]:
    """Differences of two jobs but for their inputs: keys, then modules, then packages."""
    modules = _leaves(old.code.parts, new.code.parts)
    packages = _leaves(old.code.versions, new.code.versions)
    return [
        *(_change(_key(new.stage, leaf, keys), leaf) for leaf in _leaves(old.section, new.section)),
        *(f"source {name} changed" for (name,), *_ in modules),
        *(_change(f"package {leaf[0][0]}", leaf) for leaf in packages),
    ]


def _key(stage: str, leaf: Leaf, keys: Sequence[Leaf]) -> str:
    """Configuration key behind a section's leaf, which has names of its own.

    It has the same last name and values, and a path most like that of the leaf.
    """
    path, *values = leaf
    same = [p for p, *others in keys if p[-1] == path[-1] and others == values]
    near = {*path, *stage.split("_")}
    return ".".join(max(same, key=lambda p: len(near.intersection(p)) - len(p) / 100, default=path))


def _change(name: str, leaf: Leaf) -> str:
    return f"{name} {_brief(leaf[1])} → {_brief(leaf[2])}"


def _brief(value: Any) -> str:
    if value is _ABSENT:
        return "none"
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= _WIDTH else f"{text[: _WIDTH - 1]}…"


def _leaves(old: Any, new: Any, path: tuple[str, ...] = ()) -> Iterator[Leaf]:
    """Values that differ, in the order of the second tree."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for name in dict.fromkeys([*new, *old]):
            yield from _leaves(old.get(name, _ABSENT), new.get(name, _ABSENT), (*path, str(name)))
        if {*old} == {*new} and [*old] != [*new]:  # the order of terms has a meaning
            yield (*path, "order"), [*old], [*new]
    elif type(old) is not type(new) or old != new:
        yield path, old, new
