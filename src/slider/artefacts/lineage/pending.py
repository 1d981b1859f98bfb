"""What a target would compute, and because of which change since its last result."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from slider.artefacts.lineage.causes import Cause, Comparison, pairs
from slider.artefacts.lineage.compare import parts_in
from slider.artefacts.lineage.targets import Found, Layout, layouts, manifest_of
from slider.artefacts.plan import JobSpec
from slider.artefacts.store import Store

NEVER = "never computed"
LOST = "object damaged or missing"


@dataclass(frozen=True)
class Pending:
    """A job without a whole result.

    Attributes:
        job: the job.
        causes: what changed in it since the last result.
        inputs: stages of inputs that changed, are new or are gone.
        state: why there is no result, where nothing changed.
        reused: whether the store has a result of the same section, source and input contents.
    """

    job: JobSpec
    causes: tuple[Cause, ...] = ()
    inputs: tuple[str, ...] = ()
    state: str = ""
    reused: bool = False


def pending(wanted: Found, store: Store, last: Found | None) -> list[Pending]:
    """Jobs that lead to a wanted one and have no whole result in a store, inputs first.

    Args:
        wanted: the job; its store has the modules of its source.
        store: results.
        last: the job of the last result, to say what changed.
    """
    todo = _todo(wanted.job, store)
    if last is None:
        return [_lost(job, None, store) for job in todo]
    partners = dict(_partners(last.job, wanted.job))
    comparison = Comparison(last.plan, wanted.plan, parts_in(store, wanted.store))
    found = [_explain(job, partners.get(job.recipe), comparison, store) for job in todo]
    shaping = tuple(comparison.shaping())
    other = [one.inputs and _has_other_inputs(partners[one.job.recipe], one.job) for one in found]
    return [
        replace(one, causes=(*one.causes, *shaping)) if more else one
        for one, more in zip(found, other, strict=True)
    ]


def last_result(wanted: Found, store: Store) -> Found | None:
    """The latest job of a wanted one's name that was computed, or else that was planned."""
    if _was_computed(store, wanted.job.stage, wanted.job.recipe):
        return Found(store, wanted.plan, wanted.job)
    planned = [(one, recipe) for one in layouts(store) if (recipe := namesake(wanted, one))]
    computed = (
        (one, recipe)
        for one, recipe in planned
        if _was_computed(store, one.jobs[recipe]["stage"], recipe)
    )
    layout, recipe = next(computed, planned[0] if planned else (None, None))
    return Found(store, layout.plan, layout.plan.jobs[recipe]) if layout and recipe else None


def namesake(wanted: Found, layout: Layout) -> str | None:
    """Recipe of a plan's job that has the target, or else stage and label, of a wanted one.

    Of several it is the same job, or else the one in its place among them.
    """
    if wanted.name in wanted.plan.targets:
        return layout.values["targets"].get(wanted.name)
    named = wanted.job.stage, wanted.job.label
    there = [r for r, job in layout.jobs.items() if (job["stage"], job["label"]) == named]
    if wanted.job.recipe in there:
        return wanted.job.recipe
    jobs = wanted.plan.jobs.items()
    here = [recipe for recipe, job in jobs if (job.stage, job.label) == named]
    return next(iter(there[here.index(wanted.job.recipe) :]), None)


def _partners(old: JobSpec, new: JobSpec) -> Iterator[tuple[str, JobSpec]]:
    """Recipe of each job towards the new one → the job in its place towards the old one."""
    waiting, seen = [(old, new)], set[str]()
    while waiting:
        before, after = waiting.pop()
        if after.recipe in seen:
            continue
        seen.add(after.recipe)
        yield after.recipe, before
        waiting += [(a, b) for a, b in pairs(before, after) if a and b]


def _todo(wanted: JobSpec, store: Store) -> list[JobSpec]:
    found: list[JobSpec] = []
    seen: set[str] = set()

    def visit(job: JobSpec) -> None:
        if job.recipe in seen:
            return
        seen.add(job.recipe)
        if _object(store, job):
            return
        for group in job.inputs.values():
            for item in group:
                visit(item)
        found.append(job)

    visit(wanted)
    return found


def _object(store: Store, job: JobSpec) -> str | None:
    """Object of a job, if it is whole."""
    manifest = manifest_of(store, job)
    whole = manifest and store.is_whole(manifest.result.object)
    return manifest.result.object if manifest and whole else None


def _explain(
    job: JobSpec,
    before: JobSpec | None,
    comparison: Comparison,
    store: Store,
) -> Pending:
    if (
        before is None
        or before.recipe == job.recipe
        or not _was_computed(store, before.stage, before.recipe)
    ):
        return _lost(job, before, store)
    differing = [(a or b, a, b) for a, b in pairs(before, job)]
    stages = [
        one.stage for one, a, b in differing if one and not (a and b and a.recipe == b.recipe)
    ]
    return Pending(
        job,
        tuple(comparison.own(before, job)),
        tuple(dict.fromkeys(stages)),
        reused=_is_known(job, store),
    )


def _lost(job: JobSpec, before: JobSpec | None, store: Store) -> Pending:
    """A job without anything that it can be compared with."""
    lost = before is not None and _was_computed(store, job.stage, job.recipe)
    return Pending(job, state=LOST if lost else NEVER, reused=_is_known(job, store))


def _was_computed(store: Store, stage: str, recipe: str) -> bool:
    """Tell whether there is any trace of a result of a job, whole or not.

    The facts of one that was pulled and waits for its inputs are none.
    """
    if store.manifest_path(stage, recipe).is_file():
        return True
    noted = store.sidecar_path(stage, recipe).is_file()
    return noted and not store.facts(stage, recipe).get("waiting", False)


def _has_other_inputs(before: JobSpec, job: JobSpec) -> bool:
    return any(a is None or b is None for a, b in pairs(before, job))


def _is_known(job: JobSpec, store: Store) -> bool:
    """Tell whether the early cut-off would find a result; unknown inputs say no."""
    found = {name: [_object(store, item) for item in jobs] for name, jobs in job.inputs.items()}
    objects = {name: [digest for digest in group if digest] for name, group in found.items()}
    if objects != found:
        return False
    return store.known(job.key(objects)) is not None
