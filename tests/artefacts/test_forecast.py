"""Expected times, results that are reused, and schedules that are known by hand."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from slider.artefacts.forecast import (
    START,
    Forecast,
    Work,
    expected,
    kind,
    remembered,
    reused_ahead,
    size,
)
from slider.artefacts.plan import JobSpec, build_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from tests.artefacts.samples import compute


def chain_and_fillers(cores: int) -> Forecast:
    """A chain of 10, 20 and 30 s beside four jobs of 15 s."""
    chain = {
        "a": Work(10.0, (), 1),
        "b": Work(20.0, ("a",), 1),
        "c": Work(30.0, ("b", "there already"), 1),
    }
    return Forecast(chain | {f"f{k}": Work(15.0) for k in range(4)}, cores)


@pytest.mark.parametrize(("cores", "left"), [(1, 120.0), (2, 60.0), (3, 60.0), (7, 60.0)])
def test_the_time_left_is_that_of_the_schedule(cores, left):
    assert chain_and_fillers(cores).left(0.0) == pytest.approx(left)


def test_the_urgent_job_starts_first_and_a_wide_one_waits_for_its_cores():
    late = {"a": Work(10.0), "b": Work(30.0, (), 1), "c": Work(20.0)}
    assert Forecast(late, 2).left(0.0) == pytest.approx(30.0)
    wide = {"one": Work(10.0), "wide": Work(5.0, threads=2), "runs": Work(8.0)}
    forecast = Forecast(wide, 2)
    forecast.begin("runs", 0.0)
    assert forecast.left(0.0) == pytest.approx(15.0)  # `one` takes the free core, then `wide` both


def test_a_running_job_counts_by_its_time_and_by_its_own_share():
    forecast = chain_and_fillers(1)
    forecast.begin("a", 100.0)
    assert forecast.left(104.0) == pytest.approx(116.0)
    assert forecast.share(104.0) == pytest.approx(4.0 / 120.0)
    forecast.shares = {"a": 0.2}  # 4 s were a fifth of it
    assert forecast.left(104.0) == pytest.approx(16.0 + 110.0)


def test_a_slower_machine_is_noticed_and_reused_results_are_not():
    forecast = chain_and_fillers(1)
    forecast.begin("f0", 0.0)
    forecast.end("f0", 0.5, reused=True)
    assert forecast.left(0.5) == pytest.approx(105.0)
    forecast.begin("f1", 1.0)
    forecast.end("f1", 31.0)
    pace = (30.0 + 20.0) / (15.0 + 20.0)
    assert forecast.left(31.0) == pytest.approx(90.0 * pace)


def test_nothing_is_left_at_the_end():
    forecast = Forecast({"a": Work(10.0)}, 1)
    forecast.begin("a", 0.0)
    forecast.end("a", 12.0)
    assert (forecast.left(12.0), forecast.share(12.0)) == (0.0, 1.0)


def evaluation(robots: int, controller: str = "hzd") -> JobSpec:
    protocol = {"trials": 1, "robots": robots, "duration": 1.0}
    section = {"controller": controller, "evaluation": protocol}
    return JobSpec("baseline", "label", Code("a:run", "", {}), section)


def note(store: Store, job: JobSpec, **facts) -> None:
    path = store.sidecar_path(job.stage, job.recipe)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"kind": kind(job), "size": size(job)} | facts))


def test_times_are_those_of_earlier_jobs_in_proportion_to_their_size(tmp_path):
    store = Store(tmp_path)
    job, other = evaluation(100), evaluation(100, "mine")
    shipped = remembered(store, ["baseline"])
    assert expected(job, shipped) == pytest.approx(START + 0.5663, rel=1e-3)
    assert expected(other, shipped) == START + 5.0
    note(store, job, computed=True, wall_s=90.0, cpu_s=60.0)  # other programs' load is not ours
    note(store, evaluation(7), computed=False, wall_s=0.1, cpu_s=0.1)
    (tmp_path / "baseline" / "torn.run.json").write_text("{")
    rates = remembered(store, ["baseline"])
    assert expected(job, rates) == pytest.approx(START + 60.0)
    assert expected(evaluation(200), rates) == pytest.approx(START + 120.0)


def test_equal_contents_are_reused_through_a_job_that_has_another_recipe(tmp_path: Path):
    """As after a refactoring and its undoing: the recipe of the first job changes, no content."""
    store = Store(tmp_path)
    before, after = (JobSpec("gait", "gait", Code("a:run", text, {}), {}) for text in ("a", "b"))
    library = JobSpec("library", "library", Code("a:run", "", {}), {}, {"gaits": [before]})
    content = compute(store, before).result.object
    compute(store, library)
    again = replace(library, inputs={"gaits": [after]})
    plan, both = build_plan({"library": again}), {after.recipe, again.recipe}
    assert reused_ahead(plan, store, both) == set()
    compute(store, after)  # it ran and gave the same
    assert reused_ahead(plan, store, {again.recipe}) == {again.recipe}
    assert reused_ahead(plan, store, both) == both
    store.drop_object(content)
    assert reused_ahead(plan, store, both) == set()
