"""What two results differ by: each cause once, followed to where it begins."""

import json
import shutil

import pytest

from slider.artefacts import runner
from slider.artefacts.lineage.compare import compare
from slider.artefacts.lineage.targets import Found
from slider.artefacts.lineage.text import differing
from slider.artefacts.plan import read_plan, write_plan
from slider.artefacts.store import Store
from slider.core import files

OTHER = "def cost(mass):\n    return mass // 10 + 1\n"


def lines(old, new) -> list[str]:
    return [line.strip() for line in differing(compare(old, new))]


def test_the_same_job_has_no_difference(world):
    found = world.compute(world.plan())
    assert compare(found, found) == []


def test_a_key_is_named_as_people_set_it_and_with_the_jobs_that_read_it(world):
    heavy = {"mass": 14.5, "links": {"foot": 0.07}}
    old, new = world.found(world.plan()), world.found(world.plan(robot=heavy, trials=3))
    assert lines(old, new) == [
        "gait × 2: robot.mass 14.0 → 14.5",
        "table: evaluation.trials 10 → 3",
    ]
    (first, _) = compare(old, new)
    assert [job.label for job in first.jobs] == ["gait 0.00 m/s", "gait 0.50 m/s"]


@pytest.mark.parametrize(
    ("robot", "text"),
    [
        ({"mass": 14.0, "links": {}}, "robot.links.foot 0.07 → none"),
        ({"mass": 14, "links": {"foot": 0.07}}, "robot.mass 14.0 → 14"),
        (
            {"links": {"foot": 0.07}, "mass": 14.0},
            'robot.order ["mass","links"] → ["links","mass"]',
        ),
        ({"mass": None, "links": {"foot": 0.07}}, "robot.mass 14.0 → null"),
    ],
)
def test_every_kind_of_change_of_a_section_is_found(world, robot, text):
    old, new = world.found(world.plan()), world.found(world.plan(robot=robot))
    assert lines(old, new) == [f"gait × 2: {text}"]


def test_a_module_is_named_with_all_that_import_it(world):
    old = world.compute(world.plan())
    world.edit("solve.py", OTHER)
    new = world.compute(world.plan())
    assert lines(old, new) == [f"gait × 2: source module {world.package}.solve changed"]


def test_a_comment_is_no_difference(world):
    old = world.compute(world.plan())
    world.edit("solve.py", "# why\ndef cost(mass):\n    return mass // 10\n")
    assert compare(old, world.found(world.plan())) == []


def test_a_module_that_nobody_noted_is_the_source(world):
    plan = world.plan()
    path = write_plan(plan, world.store.root / "plans")
    text = files.canonical(files.read_json(path) | {"sources": {}})
    earlier = path.with_stem(files.digest_text(text))
    earlier.write_text(text)
    old = world.found(read_plan(earlier))
    world.edit("solve.py", OTHER)
    new = world.found(world.plan())
    assert lines(old, new) == ["gait × 2: source changed"]


def test_a_package_is_named_with_its_versions(world):
    old = world.plan(versions={"python": "3.11", "numpy": "2.0.0"})
    new = world.plan(versions={"python": "3.11", "numpy": "2.1.0", "scipy": "1.0"})
    assert lines(world.found(old), world.found(new)) == [
        "gait × 2: package numpy 2.0.0 → 2.1.0",
        "gait × 2: package scipy none → 1.0",
    ]


def test_inputs_that_come_and_go_are_counted_with_the_key_that_says_so(world):
    old, new = world.found(world.plan()), world.found(world.plan(grid=[0.0, 0.1, 0.2]))
    assert lines(old, new) == [
        "gait × 3: gait.grid [0.0,0.5] → [0.0,0.1,0.2]",
        "gait: input no more",
        "gait × 2: new input",
    ]


def test_results_of_different_stages_are_different(world):
    plan = world.plan()
    found = compare(world.found(plan, "library"), world.found(plan))
    assert [str(one.cause) for one in found] == ["library → table"]


def test_other_bytes_for_no_known_reason_say_so(world, monkeypatch, tmp_path):
    plan, there = world.plan(), Store(tmp_path / "elsewhere")
    world.compute(plan)
    monkeypatch.setenv("TEST_BITS", "other")
    world.compute(plan, there)
    gait = next(iter(plan.jobs.values()))
    sides = [Found(store, plan, gait) for store in (world.store, there)]
    assert lines(*sides) == ["gait: other bytes of the same recipe, and nothing noted differs"]


def test_the_machine_is_named_where_the_same_recipe_gave_other_bytes(world, monkeypatch, tmp_path):
    plan, there = world.plan(), Store(tmp_path / "elsewhere")
    monkeypatch.setattr(runner, "machine", lambda: "A")
    here = world.compute(plan)
    monkeypatch.setattr(runner, "machine", lambda: "B")
    same = world.compute(plan, there)
    assert compare(here, same) == []
    shutil.rmtree(there.root)
    monkeypatch.setenv("TEST_BITS", "of another processor")
    world.compute(plan, there)
    sidecar = there.sidecar_path("gait", here.job.inputs["library"][0].inputs["gaits"][0].recipe)
    sidecar.write_text(
        json.dumps(
            json.loads(sidecar.read_text()) | {"commit": "c0ffee", "taken_from": "s3://theirs"}
        )
    )
    libraries = [world.found(plan, "library", store) for store in (world.store, there)]
    assert compare(*libraries) == []  # they are the same again
    gaits = [job for job in plan.jobs.values() if job.stage == "gait"]
    for job, expected in zip(gaits, (["commit", "machine"], ["machine"]), strict=True):
        sides = [Found(store, plan, job) for store in (world.store, there)]
        causes = [one.cause for one in compare(*sides)]
        assert [cause.kind for cause in causes] == ["circumstance"] * len(expected)
        assert sorted(cause.name for cause in causes) == expected
    assert "machine A → B" in map(str, causes)
