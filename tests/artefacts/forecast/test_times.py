"""Expected times of jobs: what is remembered of their kind and size, else what ships."""

import json
from pathlib import Path
from typing import Any

import pytest

from pipeline.stages import all_jobs, table1_jobs
from pipeline.stages.entries import ENTRIES
from pipeline.stages.page import video
from pipeline.studies import study_job
from slider.artefacts.forecast import times
from slider.artefacts.forecast.times import START, Row, Times
from slider.artefacts.plan import JobSpec, build_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from slider.config.compose import compose
from slider.core.threads import duration

CONF = Path(__file__).parents[3] / "conf"
SHIPPED = [Row("baseline hzd", 100.0, 50.0), Row("baseline tuned", 100.0, 30.0)]


def evaluation(controller: str, robots: int, stage: str = "baseline") -> JobSpec:
    section = {
        "controller": controller,
        "evaluation": {"trials": 1, "robots": robots, "duration": 1.0},
    }
    return JobSpec(stage, "label", Code("a:run", "", {}), section)


@pytest.mark.parametrize(
    ("controller", "robots", "seconds"),
    [
        ("hzd", 100, 50.0),
        ("hzd", 200, 1.5 + 2 * 48.5),  # imports take as long
        ("mine", 100, 40.0),  # the mean of its stage
    ],
)
def test_the_table_that_ships_is_scaled(controller, robots, seconds):
    found = Times([], SHIPPED).seconds(evaluation(controller, robots))
    assert found == pytest.approx(START + seconds)


def test_what_is_remembered_of_a_like_size_comes_first():
    remembered = [Row("baseline hzd", 100.0, s) for s in (19.0, 20.0, 90.0)]
    known = Times([*remembered, Row("baseline hzd", 1.0, 3.0)], SHIPPED)
    assert known.seconds(evaluation("hzd", 100)) == pytest.approx(START + 20.0)
    assert known.seconds(evaluation("hzd", 1000)) == pytest.approx(START + 1.5 + 10 * 48.5)
    assert known.seconds(evaluation("tuned", 100)) == pytest.approx(START + 30.0)


def test_more_threads_take_less_time_but_for_the_networks():
    known = Times([Row("baseline hzd", 100.0, 100.0)], [])
    seconds = [known.seconds(evaluation("hzd", 100), threads) for threads in (1, 2, 1024)]
    assert seconds[0] == START + 100.0 > seconds[1] > seconds[2] > START + 40.0


def test_a_job_without_work_takes_as_long_as_an_earlier_one():
    job = evaluation("hzd", 0)
    assert Times([Row("baseline hzd", 0.0, 3.0)], []).seconds(job) == START + 3.0
    assert Times([], [Row("baseline hzd", 0.0, 3.0)]).seconds(evaluation("hzd", 9)) == START + 3.0


def note(job, threads: int = 1) -> dict:
    return {"kind": times.kind(job), "size": times.size(job), "threads": threads}


def test_the_store_remembers_what_was_computed_and_no_load(tmp_path):
    store, jobs = Store(tmp_path), [evaluation("hzd", robots) for robots in range(1, 7)]
    facts = [
        {"computed": True, "wall_s": 90.0, "cpu_s": 60.0, **note(jobs[0])},
        {"computed": False, "wall_s": 1.0, "cpu_s": 1.0, **note(jobs[1])},
        {"computed": True, "wall_s": 1.0, "cpu_s": 1.0},  # of an earlier version
        {"computed": True, "wall_s": 50.0, "cpu_s": 95.0, **note(jobs[3], 2)},
        {"computed": True, "wall_s": 610.0, "cpu_s": 686.0, **note(jobs[4], 2)},  # beside others
    ]
    texts = [*map(json.dumps, facts), "[3"]
    for job, text in zip(jobs, texts, strict=True):
        path = store.sidecar_path(job.stage, job.recipe)
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    found = sorted(row.seconds for row in times.times(store, ["baseline", "gait"]).remembered)
    assert found == [60.0, 50.0 / duration(2), 686.0]


def test_a_table_is_written_as_it_is_read(tmp_path, monkeypatch):
    rows = [Row("a", 10.0, 4.0), Row("a", 10.0, 6.0), Row("a", 1.0, 1.0), Row("b c", 2.0, 90.0)]
    times.write(times.mean_rows(rows), tmp_path / times.TABLE)
    monkeypatch.setattr(times, "package_files", lambda package: tmp_path)
    assert times.shipped() == [Row("b c", 2.0, 90.0), Row("a", 10.0, 5.0)]


def test_each_value_that_a_size_is_a_product_of_is_in_the_section_of_its_stage():
    """One that was renamed would count as 1."""
    config = compose([], CONF)
    targets = all_jobs(config)
    targets["starts"] = study_job("gait_starts", config, targets, [], CONF)
    targets |= {"c": video(config, "policy", 0.2, targets)}  # the page has one with a renderer
    way = {job.stage: job.section for job in build_plan(targets).jobs.values()}
    for stage, keys in times._FACTORS.items():
        for key in keys:
            value: Any = way[stage]
            for part in key.split("."):
                value = value[part]
            assert isinstance(value, int | float | list), (stage, key)


def test_the_stages_of_table_1_are_in_the_table_that_ships_in_about_their_size():
    rows = times.shipped()
    assert {row.kind.partition(" ")[0] for row in rows} <= set(ENTRIES)
    way = {job.stage: job for job in build_plan(table1_jobs(compose([], CONF))).jobs.values()}
    for stage in way.keys() - {"stability", "stability_figures", "basin"}:
        sizes = [row.size for row in rows if row.kind.partition(" ")[0] == stage]
        assert sizes, stage
        assert all(size / 4 <= times.size(way[stage]) <= 4 * size for size in sizes), stage
