"""What would be computed, because of which change, as the runner then does it."""

import pytest

from slider.artefacts.lineage.pending import last_result, pending
from slider.artefacts.lineage.text import waiting
from slider.artefacts.plan import build_plan
from slider.artefacts.runner import Runner

OTHER = "def cost(mass):\n    return mass // 10 + 1\n"
SAME = "def cost(mass):\n    return (mass) // 10 + 0\n"
HEAVY = {"mass": 34.0, "links": {"foot": 0.07}}


def jobs(world, plan, target="table1"):
    wanted = world.found(plan, target)
    return pending(wanted, world.store, last_result(wanted, world.store))


def lines(world, plan, target="table1") -> list[str]:
    return [line.strip() for line in waiting(jobs(world, plan, target))]


@pytest.fixture
def done(world):
    world.compute(world.plan())
    return world


def test_nothing_is_left_of_a_whole_result(done):
    assert jobs(done, done.plan()) == []


def test_nothing_was_computed_yet(world):
    plan = world.lay_out(world.plan())
    expected = ["gait × 2: never computed", "library: never computed", "table: never computed"]
    assert lines(world, plan) == expected


def test_a_key_and_what_follows_from_it(done):
    assert lines(done, done.plan(robot=HEAVY)) == [
        "gait × 2: robot.mass 14.0 → 34.0",
        "library: input gait",
        "table: input library",
    ]


def test_a_module_and_what_follows_from_it(done):
    done.edit("solve.py", OTHER)
    plan = done.lay_out(done.plan())
    assert lines(done, plan) == [
        f"gait × 2: source module {done.package}.solve changed",
        "library: input gait",
        "table: input library",
    ]


def test_a_package(done):
    found = lines(done, done.plan(versions={"python": "2.7"}))
    assert found[0] == "gait × 2: package python 3.11 → 2.7"


def test_a_wider_grid_computes_the_new_gait_alone(done):
    assert lines(done, done.plan(grid=[0.0, 0.5, 1.0])) == [
        "gait: never computed",
        "library: gait.grid [0.0,0.5] → [0.0,0.5,1.0]; input gait",
        "table: input library",
    ]


def test_the_last_result_counts_not_the_last_plan(done):
    """A dry run of another configuration computes nothing."""
    done.lay_out(done.plan(trials=7))
    assert lines(done, done.plan(trials=3)) == ["table: evaluation.trials 10 → 3"]


def test_what_was_computed_of_an_unfinished_run_is_not_computed_again(done):
    plan = done.lay_out(done.plan(robot=HEAVY))
    for job in [job for job in plan.jobs.values() if job.stage == "gait"]:
        Runner(done.store).run(job)
    assert lines(done, plan) == ["library: input gait", "table: input library"]


def test_known_contents_are_reused(done):
    """Gaits of another source are the same: the runner computes no library."""
    done.edit("solve.py", SAME)
    plan = done.lay_out(done.plan())
    gaits = [job for job in plan.jobs.values() if job.stage == "gait"]
    for job in gaits:
        Runner(done.store).run(job)
    first, _ = jobs(done, plan)
    assert first.reused
    assert lines(done, plan)[0] == "library: input gait (reused: content known)"
    assert Runner(done.store).run(first.job) == "reused"


@pytest.mark.parametrize("harm", ["damaged", "missing", "dropped"])
def test_a_lost_object(done, harm):
    found = done.found(done.plan())
    folder = done.store.object_folder(found.manifest.result.object)
    if harm == "damaged":
        (folder / "table.csv").chmod(0o600)
        (folder / "table.csv").write_text("9\n")
    else:
        done.store.drop_object(found.manifest.result.object)
    if harm == "dropped":
        done.store.manifest_path("table", found.job.recipe).unlink()
    assert lines(done, done.plan()) == ["table: object damaged or missing"]


def test_a_lost_object_before_a_whole_result_is_not_needed(done):
    library = done.found(done.plan(), "library")
    done.store.drop_object(library.manifest.result.object)
    assert jobs(done, done.plan()) == []
    assert lines(done, done.plan(), "library") == ["library: object damaged or missing"]


def test_it_names_the_jobs_that_the_runner_then_computes(done):
    plan = done.lay_out(done.plan(robot=HEAVY, trials=3))
    expected = {one.job.recipe for one in jobs(done, plan)}
    target = done.found(plan).job
    outcomes = {
        job.recipe: Runner(done.store).run(job) for job in build_plan({"t": target}).jobs.values()
    }
    assert {recipe for recipe, outcome in outcomes.items() if outcome != "reused"} == expected
