"""What a person sees of a run, from events of a scheduler and files of a store."""

from datetime import UTC, datetime

import pytest

from pipeline import progress
from pipeline.progress import Progress, share, table
from slider.artefacts.plan import JobSpec, build_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from tests.artefacts.samples import compute

CODE = Code("a:run", "", {})


def evaluation(stage: str, controller: str, speed: float) -> JobSpec:
    protocol = {"trials": 10, "robots": 200, "duration": 10.0}
    section = {"controller": controller, "speed": speed, "evaluation": protocol}
    return JobSpec(stage, f"evaluation of {controller} at {speed}", CODE, section)


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Two evaluations of the policy, one of a baseline, the table; time stands still."""
    jobs = [evaluation("evaluation", "policy", speed) for speed in (0.2, 0.4)]
    jobs.append(evaluation("baseline", "hzd", 0.2))
    section = {"labels": {"policy": "policy (ours)", "hzd": "HZD"}}
    table1 = JobSpec("table1", "table 1", CODE, section, {"evaluations": jobs})
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
    summary = {name: job.section[name] for name in ("controller", "speed")}
    summary |= {"success_rate": 1.0, "mse_steady": 0.25}
    ended = datetime.fromtimestamp(now[0] - ago, UTC).isoformat()
    compute(store, job, "", summary, {"computed": computed, "ended": ended, "wall_s": seconds})
    shown.ended(job.recipe)


def test_a_line_per_job_and_the_table_at_the_end(run, tmp_path):
    shown, jobs, lines, now = run
    finish(run, tmp_path, jobs[0], 30.0)
    assert lines[0].startswith("[1/4  ")
    assert "min left] evaluation of policy at 0.2: 30.0 s" in lines[0]
    finish(run, tmp_path, jobs[1], 0.6, computed=False)
    assert lines[1].startswith("[2/4  ")
    assert lines[1].endswith("evaluation of policy at 0.4: reused")
    finish(run, tmp_path, jobs[2], 60.0)
    table1 = shown._plan.targets["table1"]
    shown.began(table1)
    shown.ended(table1)
    assert lines[-1].startswith("[4/4  100 %] table 1")
    now[0] += 1200.0  # of other jobs, such as those of the page
    shown.close(True)
    assert "HZD" in lines[-2]
    assert lines[-1].startswith("Table 1 took 2 min: reports/table1.md")


def test_a_result_of_an_earlier_run_is_reused(run, tmp_path):
    """The manifest was lost and is written again: the times beside it are of another day."""
    _, jobs, lines, _ = run
    finish(run, tmp_path, jobs[0], 1.0, ago=86400.0)
    assert lines[-1].endswith("reused")


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


def test_the_time_left_is_the_sum_over_the_cores_or_the_longest_job(run, tmp_path):
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
    path = Store(tmp_path).progress_path(jobs[2].stage, jobs[2].recipe)
    path.parent.mkdir(parents=True)
    path.write_text("20 %")  # 4 s were a fifth of it
    assert shown.left() == pytest.approx((31.0 + 16.0) / 2)
    shown.ended(jobs[2].recipe)
    assert shown.left() == 20.0


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ("iteration 20/80, 10.3 k steps/s, 0.4 min left, success 84 %", 0.25),
        ("3 of 12 gaits", 0.25),
        ("built, 50 %", 0.0),
        ("100 %", 0.99),
        ("0 of 0", 0.0),
    ],
)
def test_a_job_says_how_far_it_is(message, expected):
    assert share(message) == pytest.approx(expected)


def test_a_table_has_a_column_per_speed_and_errors_of_survivors():
    policy = {"controller": "policy", "success_rate": 0.995}
    summaries = [
        policy | {"speed": 0.2, "mse_steady": 0.00123},
        policy | {"speed": 0.4, "mse_steady": 1.5},
        {"controller": "hzd", "speed": 0.2, "success_rate": 0.0, "mse_steady": None},
    ]
    lines = [line.split() for line in table({"policy": "ours"}, summaries).splitlines()]
    assert lines[0] == ["speed", "[m/s]", "0.2", "0.4"]
    assert lines[1] == ["ours", "success", "[%]", "99.5", "99.5"]
    assert lines[2][-2:] == ["0.00123", "1.50"]
    assert lines[3] == ["hzd", "success", "[%]", "0", "–"]
    assert lines[4][-2:] == ["∞", "–"]
