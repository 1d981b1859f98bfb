"""What is noted beside a result: when, where and how long it was computed."""

from typing import Any

from slider.artefacts.plan import JobSpec
from slider.artefacts.store import Store


def facts_of(store: Store, job: JobSpec) -> dict[str, Any]:
    """Facts of the run that computed a job; nothing where they are missing or damaged."""
    return store.facts(job.stage, job.recipe)


def was_computed(store: Store, stage: str, recipe: str) -> bool:
    """Tell whether there is any trace of a result of a job, whole or not."""
    paths = store.manifest_path(stage, recipe), store.sidecar_path(stage, recipe)
    return any(path.is_file() for path in paths)
