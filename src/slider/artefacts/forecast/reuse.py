"""Which jobs will find an earlier result, known before they run."""

from collections.abc import Set

from slider.artefacts.manifest import readable
from slider.artefacts.plan import Plan
from slider.artefacts.store import Store


def reused_ahead(plan: Plan, store: Store, needed: Set[str]) -> set[str]:
    """Recipes among the needed ones whose key the index knows, with the inputs that they will have.

    What no job of the run needs may lack a manifest.
    """
    objects: dict[str, str] = {}
    known: set[str] = set()
    for recipe, job in plan.jobs.items():  # inputs come first
        if recipe not in needed:
            manifest = readable(store.manifest_path(job.stage, recipe))
        elif all(item.recipe in objects for item in job.needs):
            found = {name: [objects[i.recipe] for i in jobs] for name, jobs in job.inputs.items()}
            manifest = store.known(job.key(found))
            known |= {recipe} if manifest else set()
        else:
            continue
        if manifest is not None:
            objects[recipe] = manifest.result.object
    return known
