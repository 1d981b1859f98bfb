"""Why jobs must run."""

import os
from collections.abc import Mapping
from typing import Any

import pytest

from slider.artefacts.current import find_target
from slider.artefacts.lineage import LOST, NEVER, pending
from slider.artefacts.plan import JobSpec, Plan, build_plan, write_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from slider.cli import main
from slider.core import files
from slider.core.errors import UserError
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
    keys = {"robot": robot, "evaluation": {"trials": trials}, "gait": {"grid": list(grid)}}
    page = JobSpec("report", "the page", OTHER, {"configuration": keys})
    return build_plan({"library": library, "table1": table, "report": page})


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


def why(store: Store, plan: Plan) -> list[str]:
    lay_out(store, plan)
    jobs = pending(plan, "table1", store)
    return [f"{job.label}: {'; '.join(reasons)}" for job, reasons in jobs]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"robot": ROBOT | {"mass": None}}, "robot.mass 14.0 → null"),
        (
            {"robot": dict(reversed(ROBOT.items()))},
            'robot.order ["mass", "links"] → ["links", "mass"]',
        ),
        (
            {"cost": "another", "versions": VERSIONS | {"numpy": "2.1.0", "scipy": "1.0"}},
            "source gait.cost changed; package numpy 2.0.0 → 2.1.0; package scipy none → 1.0",
        ),
    ],
)
def test_causes_are_keys_as_people_set_them_modules_and_packages(store, change, expected):
    run(store, plan_of())
    assert why(store, plan_of(**change))[0] == f"gait 0.00 m/s: {expected}"


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
    assert why(store, plan_of(trials=3)) == ["the table: evaluation.trials 10 → 3"]
    table = store.read_manifest("table", plan.targets["table1"])
    store.drop_object(table.result.object)
    assert why(store, plan) == [f"the table: {LOST}"]


@pytest.mark.parametrize("text", ["table1", "reports/table1.csv", "artefacts/table1.json"])
def test_a_report_leads_to_its_target(text):
    assert find_target(text, plan_of()) == "table1"


def test_an_unknown_target_has_a_suggestion():
    with pytest.raises(UserError, match="found 'tabel1'; did you mean table1"):
        find_target("tabel1", plan_of())
    with pytest.raises(UserError, match="targets: library, table1, report"):
        find_target("x", plan_of())


def test_the_command(store, refused, capsys):
    place = ["--artefacts", str(store.root)]
    assert "`snakemake -n`" in refused("why", "table1", *place)
    run(store, plan_of())
    lay_out(store, plan_of(trials=3))
    assert main(["why", "table1", *place]) == 0
    text = "  table: evaluation.trials 10 → 3\n"
    assert capsys.readouterr().out == f"table1: 1 to compute\n{text}"
