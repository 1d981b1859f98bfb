"""What a target would compute, and because of which change since its last result."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from slider.artefacts.forecast.reuse import reused_ahead
from slider.artefacts.lineage.causes import Cause, Comparison, pairs
from slider.artefacts.lineage.targets import Found, known_plans
from slider.artefacts.plan import JobSpec, Plan, build_plan
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
        wanted: the job.
        store: results.
        last: the job of the last result, to say what changed.
    """
    todo = _todo(wanted.job, store)
    reused = reused_ahead(build_plan({"": wanted.job}), store, todo.keys())
    partners = dict(_partners(last.job, wanted.job)) if last else {}
    comparison = Comparison(last.plan if last else wanted.plan, wanted.plan)
    found = [_explain(job, partners.get(job.recipe), comparison, store) for job in todo.values()]
    shaping = tuple(comparison.shaping())
    return [
        replace(one, causes=(*one.causes, *shaping * more), reused=one.job.recipe in reused)
        for one, more in found
    ]


def last_result(wanted: Found, store: Store) -> Found | None:
    """The latest job of a wanted one's name that was computed, or else that was planned."""
    if _was_computed(store, wanted.job):
        return Found(store, wanted.plan, wanted.job)
    planned = [(plan, job) for plan in known_plans(store) if (job := namesake(wanted, plan))]
    computed = [one for one in planned if _was_computed(store, one[1])]
    return next((Found(store, *one) for one in (*computed, *planned)), None)


def namesake(wanted: Found, plan: Plan) -> JobSpec | None:
    """A plan's job that has the target, or else stage and label, of a wanted one.

    Of several it is the same job, or else the one in its place among them.
    """
    if wanted.name in wanted.plan.targets:
        return plan.jobs.get(plan.targets.get(wanted.name, ""))
    here, there = (_named(one, wanted.job) for one in (wanted.plan, plan))
    place = (there if wanted.job.recipe in there else here).index(wanted.job.recipe)
    return plan.jobs[there[place]] if place < len(there) else None


def _named(plan: Plan, job: JobSpec) -> list[str]:
    """Recipes of the jobs that have a job's stage and label."""
    named = job.stage, job.label
    return [recipe for recipe, one in plan.jobs.items() if (one.stage, one.label) == named]


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


def _todo(wanted: JobSpec, store: Store) -> dict[str, JobSpec]:
    """Jobs by recipe, inputs first; what only whole results need is none of them."""
    needed, waiting = set[str](), [wanted]
    while waiting:
        job = waiting.pop()
        if job.recipe not in needed and store.whole(job.stage, job.recipe) is None:
            needed.add(job.recipe)
            waiting += job.needs
    return {r: job for r, job in build_plan({"": wanted}).jobs.items() if r in needed}


def _explain(
    job: JobSpec, before: JobSpec | None, comparison: Comparison, store: Store
) -> tuple[Pending, bool]:
    """Why a job has no result; whether it has other inputs than before, not only changed ones."""
    if before is None or before.recipe == job.recipe or not _was_computed(store, before):
        lost = before is not None and _was_computed(store, job)
        return Pending(job, state=LOST if lost else NEVER), False
    inputs = [(a, b) for a, b in pairs(before, job) if not (a and b and a.recipe == b.recipe)]
    stages = dict.fromkeys(one.stage for a, b in inputs if (one := a or b))
    other = any(a is None or b is None for a, b in inputs)
    return Pending(job, tuple(comparison.own(before, job)), tuple(stages)), other


def _was_computed(store: Store, job: JobSpec) -> bool:
    """Tell whether there is any trace of a result of a job, whole or not.

    The facts of one that was pulled and waits for its inputs are none.
    """
    if store.manifest_path(job.stage, job.recipe).is_file():
        return True
    noted = store.sidecar_path(job.stage, job.recipe).is_file()
    return noted and not store.facts(job.stage, job.recipe).get("waiting", False)
