"""Expected times, and schedules that are known by hand."""

import pytest

from slider.artefacts.forecast import START, Forecast, expected, kind, remembered, size
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from slider.cli import main
from slider.core import files


def job(name: str, *inputs: JobSpec) -> JobSpec:
    return JobSpec("any", name, Code("a:run", "", {}), {"name": name}, {"all": list(inputs)})


def chain_and_fillers(cores: int) -> tuple[Forecast, list[str]]:
    """A chain of 10, 20 and 30 s beside four jobs of 15 s, and their recipes."""
    first, there_already = job("a"), job("there already")
    second = job("b", first)
    jobs = [first, second, job("c", second, there_already), *(job(f"f{k}") for k in range(4))]
    recipes = [one.recipe for one in jobs]
    times = dict(zip(recipes, [10.0, 20.0, 30.0, *4 * [15.0]], strict=True))
    return Forecast(dict(zip(recipes, jobs, strict=True)), times, cores), recipes


@pytest.mark.parametrize(("cores", "left"), [(1, 120.0), (2, 60.0), (3, 60.0)])
def test_the_time_left_is_that_of_the_schedule(cores, left):
    assert chain_and_fillers(cores)[0].left(0.0) == pytest.approx(left)


def test_a_running_job_counts_by_its_time_and_by_its_own_share():
    forecast, (first, *_) = chain_and_fillers(1)
    forecast.began[first] = 100.0
    assert forecast.left(104.0) == pytest.approx(116.0)
    assert forecast.share(104.0) == pytest.approx(4.0 / 120.0)
    forecast.shares = {first: 0.2}  # 4 s were a fifth of it
    assert forecast.left(104.0) == pytest.approx(16.0 + 110.0)


def test_a_slower_machine_is_noticed_and_reused_results_are_not():
    forecast, recipes = chain_and_fillers(1)
    forecast.began[recipes[3]] = 0.0
    forecast.end(recipes[3], 0.5, reused=True)
    assert forecast.left(0.5) == pytest.approx(105.0)
    forecast.began[recipes[4]] = 1.0
    forecast.end(recipes[4], 31.0)
    pace = (30.0 + 20.0) / (15.0 + 20.0)
    assert forecast.left(31.0) == pytest.approx(90.0 * pace)
    for recipe in (*recipes[:3], *recipes[5:]):
        forecast.end(recipe, 40.0)
    assert (forecast.left(40.0), forecast.share(40.0)) == (0.0, 1.0)


def evaluation(robots: int, controller: str = "hzd") -> JobSpec:
    protocol = {"trials": 1, "robots": robots, "duration": 1.0}
    section = {"controller": controller, "evaluation": protocol}
    return JobSpec("baseline", "label", Code("a:run", "", {}), section)


def note(store: Store, job: JobSpec, **facts) -> None:
    path = store.sidecar_path(job.stage, job.recipe)
    files.write_json(path, {"kind": kind(job), "size": size(job)} | facts)


def test_times_are_those_of_earlier_jobs_in_proportion_to_their_size(store):
    job, other = evaluation(100), evaluation(100, "mine")
    shipped = remembered(store, ["baseline"])
    assert expected(job, shipped) == pytest.approx(START + 0.5663, rel=1e-3)
    assert expected(other, shipped) == START + 5.0
    note(store, job, computed=True, wall_s=90.0, cpu_s=60.0)  # other programs' load is not ours
    note(store, evaluation(7), computed=False, wall_s=0.1, cpu_s=0.1)
    (store.root / "baseline" / "torn.run.json").write_text("{")
    rates = remembered(store, ["baseline"])
    assert expected(job, rates) == pytest.approx(START + 60.0)
    assert expected(evaluation(200), rates) == pytest.approx(START + 120.0)


def test_store_times_adds_the_processor_seconds_of_what_ran(store, capsys):
    for robots, seconds in ((100, 60.0), (200, 180.0)):
        note(store, evaluation(robots), computed=True, wall_s=200.0, cpu_s=seconds)
        store.manifest_path("baseline", evaluation(robots).recipe).write_text("{}")
    note(store, evaluation(7), computed=False, wall_s=9.0, cpu_s=9.0)
    assert main(["store", "--artefacts", str(store.root), "times"]) == 0
    assert "baseline hzd,0.75,2,240.0" in capsys.readouterr().out.splitlines()
