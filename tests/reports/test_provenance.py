"""Which commit computed what, when, and whether in this pipeline run."""

from pathlib import Path

from slider.core.job import Job
from slider.reports.page import content
from slider.reports.table import Table, Text
from tests.reports.sources import pick, sources

OLD, NEW = "2026-01-01T00:00:00.000+00:00", "2026-01-02T00:00:00.000+00:00"


def origin(stage: str, recipe: str) -> dict:
    versions = {"numpy": "2.0"}
    return {
        "stage": stage,
        "label": f"{stage} {recipe}",
        "recipe": recipe * 8,
        "source": "s" * 12,
        "versions": versions,
    }


def facts(started: str, commit: str, dirty: str = "false", **others) -> dict:
    base = {"computed": True, "pipeline_started": started, "commit": commit * 10, "dirty": dirty}
    return base | {"wall_s": 2.0, "cpu_s": 1.0, "ended": started, "machine": "one"} | others


def table(found):
    return [[cell.text for cell in row] for row in pick(found, Table)[0].rows]


def says(found, text):
    return any(text in block.markdown for block in pick(found, Text))


def section(origins, times):
    folders = {name: [Path(f"/{i}") for i in range(len(jobs))] for name, jobs in origins.items()}
    page = {"commit": "beef" * 10, "dirty": "true", "pipeline_started": NEW}
    configuration = {"train": {"walking": {"seed": 3}}}
    job = Job(Path(), volatile=page, input_volatile=times)
    given = sources(folders, job, configuration=configuration, origins=origins)
    return content("provenance", given)


def test_counts_what_this_pipeline_run_computed():
    origins = {
        "table1.evaluations": [origin("evaluation", "a"), origin("baseline", "b")],
        "library": [origin("library", "c")],
        "another": [origin("library", "c")],  # a result that two sections use
    }
    times = {
        "table1.evaluations": [facts(NEW, "1111"), facts(NEW, "2222", computed=False)],
        "library": [facts(OLD, "3333", dirty="true", resumed=True)],
        "another": [facts(OLD, "3333", dirty="true", resumed=True)],
    }
    found = section(origins, times)
    assert says(found, "commit `beefbeef+`")
    rows = {row[0]: row[1:] for row in table(found)}
    assert list(rows) == ["gait library", "evaluation of the policy", "evaluation of the baselines"]
    assert rows["gait library"][:3] == ["1", "0", "1"]
    assert rows["gait library"][-1] == "33333333+"
    assert rows["evaluation of the policy"][:3] == ["1", "1", "0"]
    assert rows["evaluation of the baselines"][:3] == ["1", "0", "0"]
    assert says(found, "Machine: one.")


def test_results_from_before_this_was_recorded_say_so():
    origins = {"library": [origin("library", "c"), origin("library", "d")]}
    times = {"library": [{}, facts(OLD, "3333", machine="two")]}
    found = section(origins, times)
    assert table(found)[0][-1] == "33333333, not\u00a0recorded"
    assert says(found, "Machines: not\u00a0recorded (gait library); two (gait library).")
