"""Why jobs must run, and how two plans differ: a walk over the jobs of both."""

import difflib
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Cause:
    """One difference of two jobs.

    Attributes:
        kind: configuration, source, package, input or result.
        name: configuration key, module or data file, package, or stage.
        old, new: before and after, for people; ``none`` where there is no value.
    """

    kind: str
    name: str
    old: str
    new: str

    def __str__(self) -> str:
        if self.kind == "source":
            return f"source {self.name} changed"
        if self.kind == "input":
            return f"input {self.name} {'added' if self.old == 'none' else 'removed'}"
        if self.kind == "result":
            return "other bytes of the same recipe"
        package = "package " * (self.kind == "package")
        return f"{package}{self.name} {self.old} → {self.new}"


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
    partners: dict[str, JobSpec] = {recipe: old[recipe] for recipe in new if recipe in old}
    left = [job for recipe, job in old.items() if recipe not in partners]
    for place in (_stage_and_label, _stage):
        waiting: dict[Any, list[JobSpec]] = {}
        for job in left:
            waiting.setdefault(place(job), []).append(job)
        open_jobs = [job for recipe, job in new.items() if recipe not in partners]
        for job in open_jobs:
            same = waiting.get(place(job), [])
            if same and (place is _stage_and_label or _is_alone(job, left, open_jobs)):
                partners[job.recipe] = same.pop(0)
        matched = {job.recipe for job in partners.values()}
        left = [job for job in left if job.recipe not in matched]
    pairs = [(partners.get(recipe), job) for recipe, job in new.items()]
    return [*pairs, *((job, None) for job in left)]


def _stage_and_label(job: JobSpec) -> tuple[str, str]:
    return job.stage, job.label


def _stage(job: JobSpec) -> str:
    return job.stage


def _is_alone(job: JobSpec, *groups: Sequence[JobSpec]) -> bool:
    return all(sum(item.stage == job.stage for item in group) == 1 for group in groups)


def differences(
    old: Plan, new: Plan, target: str, stores: tuple[Store, Store]
) -> dict[Cause, list[JobSpec]]:
    """Causes of the difference of a target in two plans, with the jobs that they act on directly.

    Jobs of one recipe differ only where the ``stores`` of the plans hold other objects of it.
    """
    jobs = [build_plan({"": plan.jobs[plan.targets[target]]}).jobs for plan in (old, new)]
    compare = Comparison(old, new)
    causes: dict[Cause, list[JobSpec]] = {}
    differing: set[str] = set()
    for before, after in pair_jobs(*jobs):
        if before is None or after is None:
            job = before or after
            assert job is not None
            states = ("none", job.label) if before is None else (job.label, "none")
            found = [Cause("input", job.stage, *states)]
        elif before.recipe != after.recipe:
            job, found = after, compare.causes(before, after)
        else:
            job, found = after, []
            objects = {_object(store, job) for store in stores}
            if len(objects) == 2 and None not in objects:
                first = not any(item.recipe in differing for item in job.needs)
                differing.add(job.recipe)
                found = [Cause("result", job.stage, "", "")] if first else []
        for cause in found:
            causes.setdefault(cause, []).append(job)
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
    compare = Comparison(last, plan)
    before = build_plan({target: last.jobs[last.targets[target]]}).jobs
    partners = {job.recipe: old for old, job in pair_jobs(before, jobs) if job and old}
    return [
        (job, _reasons(job, partners.get(recipe), compare, store))
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


def _reasons(
    job: JobSpec, before: JobSpec | None, compare: "Comparison", store: Store
) -> list[str]:
    if before is None or before.recipe == job.recipe or not _was_computed(store, before):
        return [LOST if _was_computed(store, job) else NEVER]
    known = {item.recipe for item in before.needs}
    inputs = dict.fromkeys(item.stage for item in job.needs if item.recipe not in known)
    causes = [str(cause) for cause in compare.causes(before, job)]
    return [*causes, *[f"input {stage}" for stage in inputs]] or ["fewer inputs"]


class Comparison:
    """How jobs of one plan differ from those of another.

    Sections have names of their own. The configuration that the page shows, a job of either plan,
    gives the keys that people set.
    """

    def __init__(self, old: Plan, new: Plan) -> None:
        self._keys = list(_leaves(_configuration(old), _configuration(new)))

    def causes(self, old: JobSpec, new: JobSpec) -> list[Cause]:
        """Differences of two jobs but for their inputs: keys, then modules, then packages."""
        return [
            *(self._configured(new, leaf) for leaf in _leaves(old.section, new.section)),
            *_changes("source", old.code.parts, new.code.parts),
            *_changes("package", old.code.versions, new.code.versions),
        ]

    def _configured(self, job: JobSpec, leaf: Leaf) -> Cause:
        """The key with the same last name and values as a section's leaf, most like its path."""
        path, before, after = leaf
        same = [p for p, *values in self._keys if p[-1] == path[-1] and values == [before, after]]
        near = {*path, *job.stage.split("_")}
        key = max(same, key=lambda p: len(near.intersection(p)) - len(p) / 100, default=path)
        return Cause("configuration", ".".join(key), _brief(before), _brief(after))


def _configuration(plan: Plan) -> Mapping[str, Any]:
    recipe = plan.targets.get("report")
    return plan.jobs[recipe].section.get("configuration", {}) if recipe else {}


def _changes(kind: str, old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[Cause]:
    for name in sorted({*old, *new}):
        if old.get(name) != new.get(name):
            yield Cause(kind, name, _brief(old.get(name, _ABSENT)), _brief(new.get(name, _ABSENT)))


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
