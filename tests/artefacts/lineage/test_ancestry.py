"""What a result was made from, as a tree for people and as plain values for programs."""

import json

from slider.artefacts.lineage.ancestry import everything, steps
from slider.artefacts.lineage.text import shown
from slider.artefacts.runner import Runner
from slider.core import files


def test_the_tree_has_a_step_per_stage(world):
    top = steps(world.compute(world.plan()))
    (library,) = top.inputs
    (gaits,) = library.inputs
    found = [(step.stage, len(step.made)) for step in (top, library, gaits)]
    assert found == [("table", 1), ("library", 1), ("gait", 2)]


def test_people_see_recipe_object_time_machine_overrides_and_configuration(world):
    found = world.compute(world.plan())
    path = world.store.sidecar_path("table", found.job.recipe)
    noted = {"ended": "2026-11-23T20:44:10.8+00:00", "wall_s": 527.0, "machine": "a laptop"}
    noted |= {"commit": "c0ffee" * 7, "dirty": "true", "overrides": "gait.cost=torque"}
    files.write_json(path, files.read_json(path) | noted)
    text = "\n".join(shown(found))
    expected = (
        *("2026-11-23 20:44 UTC in 8 min 47 s", "a laptop, 1 thread", "c0ffeec0ffee with changes"),
        *("gait.cost=torque", "trials  10", found.job.recipe, found.manifest.result.object),
        *("└ gait × 2  2 recipes", "2 modules and files", "python 3.11"),
    )
    assert [part for part in expected if part not in text] == []


def test_a_result_that_is_missing_or_reused_says_so(world):
    old = world.compute(world.plan())
    plan = world.lay_out(world.plan(robot={"mass": 14.9, "links": {"foot": 0.07}}))
    assert "none: not computed" in "\n".join(shown(world.found(plan)))
    for job in [job for job in plan.jobs.values() if job.stage != "table"]:
        Runner(world.store).run(job)
    text = "\n".join(shown(world.found(plan, "library")))
    reused = old.job.inputs["library"][0].recipe
    assert f"reused from  {reused}" in text
    assert [line for line in text.splitlines() if line.endswith("reused") and "library" in line]


def test_programs_get_everything(world):
    found = world.compute(world.plan())
    values = json.loads(json.dumps(everything(found)))
    assert values["recipe"] == found.job.recipe
    assert values["configuration"] == {"trials": 10}
    assert values["code"]["versions"] == dict(found.job.code.versions)
    assert set(values["modules"]) == {world.package, f"{world.package}.table"}
    assert values["noted"]["threads"] == 1
    stages = sorted(job["stage"] for job in values["jobs"].values())
    assert stages == ["gait", "gait", "library", "table"]
    (library,) = values["inputs"]["library"]
    assert len(values["jobs"][library]["inputs"]["gaits"]) == 2
    assert all(len(job["object"]) == 64 for job in values["jobs"].values())
