"""Expected times of jobs, from those of earlier ones."""

import pytest

from slider.artefacts.forecast import START, expected, kind, known_rates, size
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from slider.cli import main
from slider.core import files


def evaluation(robots: int, controller: str = "hzd") -> JobSpec:
    protocol = {"trials": 1, "robots": robots, "duration": 1.0}
    section = {"controller": controller, "evaluation": protocol}
    return JobSpec("baseline", "label", Code("a:run", "", {}), section)


def note(store: Store, job: JobSpec, **facts) -> None:
    path = store.metadata_path(job.stage, job.recipe)
    files.write_json(path, {"kind": kind(job), "size": size(job)} | facts)


def test_times_are_those_of_earlier_jobs_in_proportion_to_their_size(store):
    job, other = evaluation(100), evaluation(100, "mine")
    shipped = known_rates(store, ["baseline"])
    assert expected(job, shipped) == pytest.approx(START + 0.5663, rel=1e-3)
    assert expected(other, shipped) == START + 5.0
    note(store, job, computed=True, wall_s=90.0, cpu_s=60.0)  # other programs' load is not ours
    note(store, evaluation(7), computed=False, wall_s=0.1, cpu_s=0.1)
    (store.root / "baseline" / "torn.run.json").write_text("{")
    rates = known_rates(store, ["baseline"])
    assert expected(job, rates) == pytest.approx(START + 60.0)
    assert expected(evaluation(200), rates) == pytest.approx(START + 120.0)


def test_store_times_adds_the_processor_seconds_of_what_ran(store, capsys):
    for robots, seconds in ((100, 60.0), (200, 180.0)):
        note(store, evaluation(robots), computed=True, wall_s=200.0, cpu_s=seconds)
        store.manifest_path("baseline", evaluation(robots).recipe).write_text("{}")
    note(store, evaluation(7), computed=False, wall_s=9.0, cpu_s=9.0)
    assert main(["store", "--artefacts", str(store.root), "times"]) == 0
    assert "baseline hzd,0.75,2,240.0" in capsys.readouterr().out.splitlines()
