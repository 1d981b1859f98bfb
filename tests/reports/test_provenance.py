"""Which commit computed what, and when."""

from pathlib import Path

from slider.core.job import Job
from slider.core.tables import markdown
from slider.reports.page import Page
from slider.reports.page import origins as origins_of

ENDED = "2026-01-01T00:00:00.000+00:00"


def origin(stage: str, recipe: str) -> dict:
    about = {"stage": stage, "label": f"{stage} {recipe}", "recipe": recipe * 8}
    return about | {"source": "s" * 12, "versions": {"numpy": "2.0"}}


def metadata(commit: str, dirty: str = "false") -> dict:
    about = {"commit": commit * 10, "dirty": dirty, "ended": ENDED, "machine": "one"}
    return about | {"wall_s": 2.0, "cpu_s": 1.0}


def section(origins, times):
    """Rows of the table, and the text around it."""
    folders = {name: [Path(f"/{i}") for i in range(len(jobs))] for name, jobs in origins.items()}
    page = {"commit": "beef" * 10, "dirty": "true"}
    given = {"configuration": {"train": {"walking": {"seed": 3}}}, "origins": origins}
    job = Job(Path(), metadata=page, input_metadata=times)
    found = [*origins_of(Page(given, folders, Path(), job))]
    return found[1].rows, markdown(found)


def test_each_stage_has_its_jobs_times_and_commits():
    origins = {
        "table1.evaluations": [origin("evaluation", "a"), origin("evaluation", "b")],
        "library": [origin("library", "c"), origin("library", "d")],
        "another": [origin("library", "c")],  # a result that two sections use
    }
    times = {
        "table1.evaluations": [metadata("1111"), metadata("2222")],
        "library": [metadata("3333", dirty="true"), {}],  # from before this was recorded
        "another": [metadata("3333", dirty="true")],
    }
    rows, text = section(origins, times)
    assert "commit `beefbeef+`" in text
    assert rows == [
        ["gait library", "2", "2.0", "1.0", "2026-01-01\u00a000:00"]
        + ["33333333+, not\u00a0recorded"],
        ["evaluation of the policy", "2", "4.0", "2.0", "2026-01-01\u00a000:00"]
        + ["11111111, 22222222"],
    ]
    assert "library,library d,dddddddd" in text
    assert "seed: 3" in text
