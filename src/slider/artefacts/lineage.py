"""Why jobs must run, and how two plans differ: a walk over the jobs of both."""

import difflib
import json
from collections.abc import Iterator, Mapping, Sequence, Set
from contextlib import suppress
from pathlib import Path
from typing import Any

from slider.artefacts.plan import JobSpec, Plan, build_plan, plan_paths, read_plan
from slider.artefacts.store import Store
from slider.core.errors import UserError

ALIASES = {"policy": "walking", "gait_library": "library", "index": "report"}
"""Names of reports whose target has another name."""
NEVER = "never computed"
LOST = "object damaged or missing"
_WIDTH = 40  # characters of a value
_ABSENT = object()
Leaf = tuple[tuple[str, ...], Any, Any]
"""Path of a value that differs, before, after."""


def recent_plans(store: Store) -> Iterator[Plan]:
    """Readable plans of a store, the one that was laid out last first."""
    for path in plan_paths(store.root / "plans"):
        with suppress(UserError):
            yield read_plan(path)


def find_target(text: str, plan: Plan) -> str:
    """Name of the target that a person means: itself, a report of it or an alias.

    Raises:
        UserError: the plan has no such target.
    """
    for name in (text, Path(text).stem):
        if (target := ALIASES.get(name, name)) in plan.targets:
            return target
    close = difflib.get_close_matches(text, plan.targets, 1, 0.6)
    hint = f"did you mean {close[0]}?" if close else f"targets: {', '.join(plan.targets)}"
    raise UserError(f"expected a target or a report of it, found '{text}'; {hint}")


def pair_jobs(
    old: Mapping[str, JobSpec], new: Mapping[str, JobSpec]
) -> list[tuple[JobSpec | None, JobSpec | None]]:
    """Pairs of jobs that stand in the same place of two plans, inputs first.

    Equal recipes come first, then equal stages and labels in their order, then what is alone in
    its stage. A job that the other plan lacks stands alone.
    """
    partners = {recipe: old[recipe] for recipe in new if recipe in old}
    for labelled in (True, False):
        paired = {job.recipe for job in partners.values()}
        left = _by_place(old, paired, labelled)
        for place, jobs in _by_place(new, partners.keys(), labelled).items():
            others = left.get(place, [])
            if labelled or len(jobs) == len(others) == 1:
                partners |= {job.recipe: other for job, other in zip(jobs, others, strict=False)}
    paired = {job.recipe for job in partners.values()}
    pairs = [(partners.get(recipe), job) for recipe, job in new.items()]
    return [*pairs, *((job, None) for recipe, job in old.items() if recipe not in paired)]


def _by_place(
    jobs: Mapping[str, JobSpec], without: Set[str], labelled: bool
) -> dict[tuple[str, str], list[JobSpec]]:
    """Jobs by stage, and by label too if asked."""
    places: dict[tuple[str, str], list[JobSpec]] = {}
    for recipe, job in jobs.items():
        if recipe not in without:
            places.setdefault((job.stage, job.label * labelled), []).append(job)
    return places


def differences(
    old: Plan, new: Plan, target: str, stores: tuple[Store, Store]
) -> dict[str, list[JobSpec]]:
    """Causes of the difference of a target in two plans, with the jobs that they act on directly.

    Jobs of one recipe differ only where the ``stores`` of the plans hold other objects of it.
    """
    jobs = [build_plan({"": plan.jobs[plan.targets[target]]}).jobs for plan in (old, new)]
    keys = _configuration_changes(old, new)
    causes: dict[str, list[JobSpec]] = {}
    differing: set[str] = set()
    for before, after in pair_jobs(*jobs):
        job, texts = after or before, list[str]()
        assert job is not None
        if before is None or after is None:
            texts = [f"input {job.stage} {'added' if before is None else 'removed'}"]
        elif before.recipe != after.recipe:
            texts = _causes(before, after, keys)
        else:
            objects = {_object(store, job) for store in stores}
            if len(objects) == 2 and None not in objects:
                if not any(item.recipe in differing for item in job.needs):
                    texts = ["other bytes of the same recipe"]
                differing.add(job.recipe)
        for text in texts:
            causes.setdefault(text, []).append(job)
    return causes


def _object(store: Store, job: JobSpec) -> str | None:
    with suppress(UserError):
        return store.read_manifest(job.stage, job.recipe).result.object
    return None


def pending(plan: Plan, target: str, store: Store) -> list[tuple[JobSpec, list[str]]]:
    """Jobs without a whole result that lead to a target, inputs first, each with its reasons.

    They are compared with those of the latest plan in which the target was computed.
    """
    top = plan.jobs[plan.targets[target]]
    needed, waiting = set[str](), [top]
    while waiting:
        job = waiting.pop()
        if job.recipe not in needed and store.whole(job.stage, job.recipe) is None:
            needed.add(job.recipe)
            waiting += job.needs
    jobs = build_plan({target: top}).jobs
    last = _last_computed(plan, target, store)
    keys = _configuration_changes(last, plan)
    before = build_plan({target: last.jobs[last.targets[target]]}).jobs
    partners = {job.recipe: old for old, job in pair_jobs(before, jobs) if job and old}
    return [
        (job, _reasons(job, partners.get(recipe), keys, store))
        for recipe, job in jobs.items()
        if recipe in needed
    ]


def _last_computed(plan: Plan, target: str, store: Store) -> Plan:
    for earlier in (plan, *recent_plans(store)):
        recipe = earlier.targets.get(target)
        if recipe and _was_computed(store, earlier.jobs[recipe]):
            return earlier
    return plan


def _was_computed(store: Store, job: JobSpec) -> bool:
    return store.manifest_path(job.stage, job.recipe).is_file()


def _reasons(job: JobSpec, before: JobSpec | None, keys: Sequence[Leaf], store: Store) -> list[str]:
    if before is None or before.recipe == job.recipe or not _was_computed(store, before):
        return [LOST if _was_computed(store, job) else NEVER]
    earlier = {item.recipe for item in before.needs}
    inputs = dict.fromkeys(item.stage for item in job.needs if item.recipe not in earlier)
    return [*_causes(before, job, keys), *(f"input {stage}" for stage in inputs)] or [
        "fewer inputs"
    ]


def _configuration_changes(old: Plan, new: Plan) -> list[Leaf]:
    """Keys that people set and that differ: the page, a job of both plans, shows them all."""
    trees = []
    for plan in (old, new):
        page = plan.jobs.get(plan.targets.get("report", ""))
        trees.append(page.section.get("configuration", {}) if page else {})
    return list(_leaves(*trees))


def _causes(old: JobSpec, new: JobSpec, keys: Sequence[Leaf]) -> list[str]:
    """Differences of two jobs but for their inputs: keys, then modules, then packages."""
    modules, packages = (
        list(_leaves(before, after))
        for before, after in (
            (old.code.parts, new.code.parts),
            (old.code.versions, new.code.versions),
        )
    )
    return [
        *(_change(_key(new.stage, leaf, keys), leaf) for leaf in _leaves(old.section, new.section)),
        *(f"source {name} changed" for (name,), *_ in modules),
        *(_change(f"package {leaf[0][0]}", leaf) for leaf in packages),
    ]


def _key(stage: str, leaf: Leaf, keys: Sequence[Leaf]) -> str:
    """Name of the key behind a section's leaf, which has names of its own.

    It has the same last name and values, and a path most like that of the leaf.
    """
    path, *values = leaf
    same = [p for p, *others in keys if p[-1] == path[-1] and others == values]
    near = {*path, *stage.split("_")}
    return ".".join(max(same, key=lambda p: len(near.intersection(p)) - len(p) / 100, default=path))


def _change(name: str, leaf: Leaf) -> str:
    return f"{name} {_brief(leaf[1])} → {_brief(leaf[2])}"


def _leaves(old: Any, new: Any, path: tuple[str, ...] = ()) -> Iterator[Leaf]:
    """Values that differ, in the order of the second tree."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for name in dict.fromkeys([*new, *old]):
            yield from _leaves(old.get(name, _ABSENT), new.get(name, _ABSENT), (*path, str(name)))
        if {*old} == {*new} and [*old] != [*new]:  # the order of terms has a meaning
            yield (*path, "order"), [*old], [*new]
    elif type(old) is not type(new) or old != new:
        yield path, old, new


def _brief(value: Any) -> str:
    if value is _ABSENT:
        return "none"
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= _WIDTH else f"{text[: _WIDTH - 1]}…"


def count(stage: str, number: int) -> str:
    """A stage, and how many jobs of it where there are several."""
    return f"{stage} × {number}" if number > 1 else stage
