"""Which commit computed what, when, and whether in this pipeline run."""

from pathlib import Path

from slider.core.job import Job
from slider.core.tables import markdown
from slider.reports.page import Page
from slider.reports.page import origins as origins_of

OLD, NEW = "2026-01-01T00:00:00.000+00:00", "2026-01-02T00:00:00.000+00:00"


def origin(stage: str, recipe: str) -> dict:
    about = {"stage": stage, "label": f"{stage} {recipe}", "recipe": recipe * 8}
    return about | {"source": "s" * 12, "versions": {"numpy": "2.0"}}


def metadata(started: str, commit: str, dirty: str = "false", **others) -> dict:
    base = {"computed": True, "pipeline_started": started, "commit": commit * 10, "dirty": dirty}
    return base | {"wall_s": 2.0, "cpu_s": 1.0, "ended": started, "machine": "one"} | others


def section(origins, times):
    """Rows of the table, and the text around it."""
    folders = {name: [Path(f"/{i}") for i in range(len(jobs))] for name, jobs in origins.items()}
    page = {"commit": "beef" * 10, "dirty": "true", "pipeline_started": NEW}
    given = {"configuration": {"train": {"walking": {"seed": 3}}}, "origins": origins}
    job = Job(Path(), metadata=page, input_metadata=times)
    found = [*origins_of(Page(given, folders, Path(), job))]
    return found[1].rows, markdown(found)


def test_counts_what_this_pipeline_run_computed():
    origins = {
        "table1.evaluations": [origin("evaluation", "a"), origin("baseline", "b")],
        "library": [origin("library", "c")],
        "another": [origin("library", "c")],  # a result that two sections use
    }
    times = {name: [metadata(OLD, "3333", dirty="true")] for name in origins}
    times["table1.evaluations"] = [metadata(NEW, "1111"), metadata(NEW, "2222", computed=False)]
    rows, text = section(origins, times)
    assert "commit `beefbeef+`" in text
    assert [row[:3] for row in rows] == [
        ["gait library", "1", "0"],
        ["evaluation of the policy", "1", "1"],
        ["evaluation of the baselines", "1", "0"],
    ]
    assert rows[0][-1] == "33333333+"
    assert "one: gait library, evaluation of the policy, evaluation of the baselines." in text


def test_results_from_before_this_was_recorded_say_so():
    origins = {"library": [origin("library", "c"), origin("library", "d")]}
    times = {"library": [{}, metadata(OLD, "3333", machine="two")]}
    rows, text = section(origins, times)
    assert rows[0][-1] == "33333333, not\u00a0recorded"
    assert "not\u00a0recorded: gait library.\n\ntwo: gait library." in text
