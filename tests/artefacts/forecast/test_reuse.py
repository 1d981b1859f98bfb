"""Which jobs will find an earlier result, told before they run."""

from pathlib import Path

import pytest

from slider.artefacts.forecast.reuse import reused_ahead
from slider.artefacts.manifest import Manifest
from slider.artefacts.plan import JobSpec, build_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store


def job(stage: str, source: str, **inputs: JobSpec) -> JobSpec:
    code = Code("a:run", source, {})
    return JobSpec(stage, stage, code, {}, {name: [item] for name, item in inputs.items()})


def compute(store: Store, spec: JobSpec, content: str, *objects: str) -> str:
    """Put a result into the store and its index; its object."""
    with store.temporary("made") as folder:
        (folder / "result.txt").write_text(content)
        result = store.publish(folder, {})
    found = {name: [objects[k]] for k, name in enumerate(spec.inputs)}
    manifest = Manifest(spec.stage, spec.recipe, {}, result, found)
    store.remember(spec.key(found), manifest)
    store.write_manifest(manifest)
    return result.object


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path)


def test_equal_contents_are_known_through_a_job_that_has_another_recipe(store):
    """As after a refactoring and its undoing: the recipe of the first job changes, no content."""
    gait = job("gait", "old")
    library = job("library", "same", gait=gait)
    made = compute(store, gait, "gait")
    compute(store, library, "library", made)
    new = job("gait", "new")
    after = job("library", "same", gait=new)
    plan = build_plan({"library": after})
    assert reused_ahead(plan, store, {new.recipe, after.recipe}) == set()
    compute(store, new, "gait")  # it ran and gave the same
    assert reused_ahead(plan, store, {after.recipe}) == {after.recipe}
    both = {new.recipe, after.recipe}
    assert reused_ahead(plan, store, both) == both
    store.drop_object(made)
    assert reused_ahead(plan, store, both) == set()
