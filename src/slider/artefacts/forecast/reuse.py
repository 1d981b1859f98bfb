"""Which jobs will find an earlier result, known before they run."""

from collections.abc import Set

from slider.artefacts.plan import Plan
from slider.artefacts.store import Store
from slider.core.errors import UserError


def reused_ahead(plan: Plan, store: Store, needed: Set[str]) -> set[str]:
    """Recipes among the needed ones whose key the index knows, with the inputs that they will have.

    A look at names and sizes alone: the jobs themselves check the content.
    """
    objects: dict[str, str] = {}
    known: set[str] = set()
    for recipe, job in plan.jobs.items():  # inputs come first
        if recipe not in needed:
            try:
                objects[recipe] = store.read_manifest(job.stage, recipe).result.object
            except UserError:
                continue  # no job of this run needs it
        elif all(item.recipe in objects for jobs in job.inputs.values() for item in jobs):
            found = {name: [objects[i.recipe] for i in jobs] for name, jobs in job.inputs.items()}
            manifest = store.usable(store.index_path(job.key(found)))
            if manifest is not None:
                objects[recipe] = manifest.result.object
                known.add(recipe)
    return known
