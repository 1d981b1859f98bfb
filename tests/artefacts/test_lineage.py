"""Why jobs must run, and what two plans differ by."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from slider.artefacts.lineage import LOST, NEVER, differences, pending
from slider.artefacts.plan import JobSpec, Plan, build_plan, plan_paths, write_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from slider.cli import main
from slider.core import files
from tests.artefacts.samples import compute

VERSIONS = {"python": "3.11", "numpy": "2.0.0"}
ROBOT = {"mass": 14.0, "links": {"foot": 0.07}}
HEAVY = ROBOT | {"mass": 14.5}
OTHER = Code("other:run", "abc", VERSIONS)


def plan_of(
    robot: Mapping[str, Any] = ROBOT,
    trials: int = 10,
    grid: tuple[float, ...] = (0.0, 0.5),
    cost: str = "cost",
    versions: Mapping[str, str] = VERSIONS,
) -> Plan:
    """Jobs of a configuration, of a source with a module `cost`, and of some packages."""
    parts = {"gait": "gait", "gait.cost": cost}
    code = Code("gait:run", files.digest_value(parts), dict(versions), parts)
    gaits = [
        JobSpec("gait", f"gait {vx:.2f} m/s", code, {"robot": robot, "velocity": [vx, 0.0, 0.0]})
        for vx in grid
    ]
    library = JobSpec("library", "the library", OTHER, {}, {"gaits": gaits})
    table = JobSpec("table", "the table", OTHER, {"trials": trials}, {"library": [library]})
    return build_plan({"library": library, "table1": table})


def lay_out(store: Store, plan: Plan) -> None:
    """Write a plan as the latest one."""
    path = write_plan(plan, store.root / "plans")
    times = [other.stat().st_mtime for other in path.parent.glob("*.json")]
    os.utime(path, (max(times) + 1,) * 2)


def run(store: Store, plan: Plan) -> Plan:
    """Lay a plan out, and leave what a run of its table would."""
    lay_out(store, plan)
    for job in plan.jobs_of("table1").values():
        compute(store, job)
    return plan


def lines(old: Plan, new: Plan, *stores: Store) -> list[str]:
    sides = stores or (Store(Path("none")), Store(Path("none")))
    causes = differences(old, new, "table1", (sides[0], sides[1]))
    return [f"{jobs[0].stage} × {len(jobs)}: {cause}" for cause, jobs in causes.items()]


def why(store: Store, plan: Plan) -> list[str]:
    lay_out(store, plan)
    jobs = pending(plan, "table1", store)
    return [f"{job.label}: {'; '.join(reasons)}" for job, reasons in jobs]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({}, []),
        (
            {"robot": HEAVY, "trials": 3},
            ["gait × 2: robot.mass 14.0 → 14.5", "table × 1: trials 10 → 3"],
        ),
        ({"robot": ROBOT | {"mass": None}}, ["gait × 2: robot.mass 14.0 → null"]),
        (
            {"robot": dict(reversed(ROBOT.items()))},
            ['gait × 2: robot.order ["mass", "links"] → ["links", "mass"]'],
        ),
        (
            {"cost": "another", "versions": VERSIONS | {"numpy": "2.1.0", "scipy": "1.0"}},
            [
                "gait × 2: package numpy 2.0.0 → 2.1.0",
                "gait × 2: package scipy none → 1.0",
                "gait × 2: source gait.cost changed",
            ],
        ),
        ({"grid": (0.0, 0.1, 0.2)}, ["gait × 2: input gait added", "gait × 1: input gait removed"]),
    ],
)
def test_every_cause_is_named_once_with_the_jobs_that_it_acts_on(change, expected):
    assert lines(plan_of(), plan_of(**change)) == expected


def test_other_bytes_of_one_recipe_are_followed_to_where_they_begin(store, tmp_path):
    plan, other = run(store, plan_of()), Store(tmp_path / "other")
    run(other, plan)
    assert lines(plan, plan, store, other) == []
    for job in plan.jobs.values():
        if job.stage in ("gait", "library"):
            compute(other, job, "of another processor")
    assert lines(plan, plan, store, other) == ["gait × 2: other bytes of the same recipe"]


def test_why_names_the_first_cause_and_then_the_inputs(store):
    gaits = ["gait 0.00 m/s", "gait 0.50 m/s"]
    everything = [f"{name}: {NEVER}" for name in (*gaits, "the library", "the table")]
    assert why(store, plan_of()) == everything
    plan = run(store, plan_of())
    assert why(store, plan) == []
    assert why(store, plan_of(robot=HEAVY)) == [
        *(f"{name}: robot.mass 14.0 → 14.5" for name in gaits),
        "the library: input gait",
        "the table: input library",
    ]
    assert why(store, plan_of(trials=3)) == ["the table: trials 10 → 3"]
    table = store.read_manifest("table", plan.targets["table1"])
    store.drop_object(table.result.object)
    assert why(store, plan) == [f"the table: {LOST}"]


def test_the_commands(store, refused, capsys):
    place = ["--artefacts", str(store.root)]
    assert "run `snakemake -n`" in refused("why", "table1", *place)
    first = run(store, plan_of())
    assert "expected a plan 'previous'" in refused("diff", "previous", "latest", *place)
    lay_out(store, plan_of(trials=3))
    text = "  table: trials 10 → 3\n"
    assert "targets: library, table1" in refused("why", "x", *place)
    for report in ("table1.csv", "gait_quality.md", "figures/tradeoff.svg"):
        assert main(["why", f"reports/{report}", *place]) == 0
        assert capsys.readouterr().out == f"table1: 1 to compute\n{text}"
    assert main(["diff", "previous", "latest", *place]) == 1
    assert capsys.readouterr().out == f"table1: 1 cause of a difference\n{text}"
    lay_out(store, first)
    path = plan_paths(store.root / "plans")[0]
    assert main(["diff", path.stem[:12], str(store.root), *place]) == 0
    assert capsys.readouterr().out == "table1: the same\n"
