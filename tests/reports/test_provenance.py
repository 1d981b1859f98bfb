"""Which commit computed what, and when."""

from pathlib import Path

from slider.core.tables import markdown
from slider.reports.provenance import Recorded, blocks


def result(stage: str, recipe: str, commit: str = "", dirty: str = "false") -> Recorded:
    """Without a commit it is from before this was recorded."""
    origin = {"stage": stage, "label": f"{stage} {recipe}", "recipe": recipe * 8}
    origin |= {"source": "s" * 12, "versions": {"numpy": "2.0"}}
    metadata = {"commit": commit * 10, "dirty": dirty, "ended": "2026-01-01T00:00:00.000+00:00"}
    metadata |= {"machine": "one", "wall_s": 2.0, "cpu_s": 1.0}
    return origin, metadata if commit else {}, Path("/0")


def test_each_stage_has_its_jobs_times_and_commits():
    """A result that two sections use counts once."""
    jobs = [result("evaluation", "a", "1111"), result("evaluation", "b", "2222")]
    jobs += [result("library", "c", "3333", "true"), result("library", "d")]
    page = {"commit": "beef" * 10, "dirty": "true"}
    found = [*blocks({"train": {"walking": {"seed": 3}}}, [*jobs, jobs[2]], page)]
    time, text = "2026-01-01\u00a000:00", markdown(found)
    assert found[1].rows == [
        ["gait library", "2", "2.0", "1.0", time, "33333333+, not\u00a0recorded"],
        ["evaluation of the policy", "2", "4.0", "2.0", time, "11111111, 22222222"],
    ]
    assert "commit `beefbeef+`" in text
    assert "library,library d,dddddddd" in text
    assert "seed: 3" in text
