"""What a person sees of a run, from events of a scheduler and files of a store."""

from datetime import UTC, datetime

import pytest

from pipeline import progress
from pipeline.progress import Progress, table
from slider.artefacts.plan import JobSpec, build_plan
from slider.artefacts.store import Store
from tests.artefacts.samples import CODE, compute

RATES = {"success_rate": 1.0, "tracking_rate": 0.5}


def evaluation(stage: str, controller: str, speed: float) -> JobSpec:
    section = {"controller": controller, "speed": speed}
    return JobSpec(stage, f"evaluation of {controller} at {speed}", CODE, section)


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Two evaluations of the policy, one of a baseline, the table; time stands still."""
    jobs = [evaluation("evaluation", "policy", speed) for speed in (0.2, 0.4)]
    jobs.append(evaluation("baseline", "hzd", 0.2))
    labels = {"labels": {"policy": "policy (ours)", "hzd": "HZD"}}
    table1 = JobSpec("table1", "table 1", CODE, labels, {"evaluations": jobs})
    plan, store = build_plan({"table1": table1}), Store(tmp_path)
    lines: list[str] = []
    now = [1000.0]
    monkeypatch.setattr(progress.time, "time", lambda: now[0])
    monkeypatch.setattr(progress, "_print", lines.append)
    return Progress(plan, store, plan.jobs, 2), jobs, lines, now


def finish(
    run, tmp_path, job: JobSpec, seconds: float, computed: bool = True, ago: float = 0.01
) -> None:
    """What a job leaves behind, and the event."""
    (shown, _, _, now), store = run, Store(tmp_path)
    shown.began(job.recipe)
    now[0] += seconds
    ended = datetime.fromtimestamp(now[0] - ago, UTC).isoformat()
    summary = {**job.section, **RATES, "mse_steady": 0.25}
    compute(store, job, "", summary, {"computed": computed, "ended": ended, "wall_s": seconds})
    shown.ended(job.recipe)


def test_a_line_per_job_and_the_table_at_the_end(run, tmp_path):
    shown, jobs, lines, _ = run
    finish(run, tmp_path, jobs[0], 30.0)
    assert lines[0].startswith("[1/4  about")
    assert lines[0].endswith("left] evaluation of policy at 0.2: 30.0 s")
    finish(run, tmp_path, jobs[1], 0.6, computed=False)
    assert lines[1].startswith("[2/4  ")
    assert lines[1].endswith("evaluation of policy at 0.4: reused")
    finish(run, tmp_path, jobs[2], 60.0, ago=86400.0)  # its lost manifest is written again
    assert lines[2].endswith("evaluation of hzd at 0.2: reused")
    table1 = shown._plan.targets["table1"]
    shown.began(table1)
    shown.ended(table1)
    assert lines[-3].startswith("[4/4] table 1")
    assert "HZD tracking [%]" in " ".join(lines[-2].split())
    assert lines[-1].startswith("reports/table1.md")


def test_a_long_job_is_shown_with_its_own_words(run, tmp_path):
    shown, jobs, lines, now = run
    for job in jobs[:2]:
        shown.began(job.recipe)
    path = Store(tmp_path).progress_path(jobs[0].stage, jobs[0].recipe)
    path.parent.mkdir(parents=True)
    path.write_text("25 %")
    now[0] += 10.0
    shown.show_running()
    assert lines[0].endswith("evaluation of policy at 0.2: 25 %; 1 more")
    path.unlink()
    shown.show_running()
    assert lines[1].endswith("evaluation of policy at 0.2: 10 s so far; 1 more")


def test_the_time_left_is_the_sum_over_the_cores_or_the_longest_job(run):
    shown, jobs, _, now = run
    times = dict(zip(shown._plan.jobs, (10.0, 20.0, 30.0, 60.0), strict=True))
    shown._seconds |= times  # of three evaluations and the table
    assert shown.left() == 60.0
    times[shown._plan.targets["table1"]] = 1.0
    shown._seconds |= times
    assert shown.left() == pytest.approx(61.0 / 2)
    shown.began(jobs[2].recipe)
    now[0] += 4.0
    assert shown.left() == pytest.approx(57.0 / 2)
    shown.ended(jobs[2].recipe)
    assert shown.left() == 20.0


def test_a_table_has_a_column_per_speed_and_errors_of_survivors():
    policy = {"controller": "policy", **RATES}
    fallen = {"controller": "hzd", **dict.fromkeys(RATES, 0.0)}
    summaries = [
        policy | {"speed": 0.2, "mse_steady": 0.00123},
        policy | {"speed": 0.4, "mse_steady": 1.5},
        fallen | {"speed": 0.2, "mse_steady": None},
    ]
    lines = [line.split() for line in table({"policy": "ours"}, summaries).splitlines()]
    assert lines[0] == ["speed", "[m/s]", "0.2", "0.4"]
    assert lines[1] == ["ours", "success", "[%]", "100", "100"]
    assert lines[2] == ["ours", "tracking", "[%]", "50", "50"]
    assert lines[3][-2:] == ["0.00123", "1.50"]
    assert lines[4] == ["hzd", "success", "[%]", "0", "–"]
    assert lines[6][-2:] == ["∞", "–"]
