"""The sensitivity's table, verdict and figure from results whose answers are known."""

import csv
import json
from pathlib import Path

import pytest

from slider.core.job import Job
from slider.reports.sensitivity import COLUMNS, read_rows, run
from slider.reports.sensitivity_effects import carrying, effects, limit, nominals
from slider.reports.sensitivity_text import verdict
from tests.evaluation.test_results import make_robots, write_evaluation

COMMANDS = [1.2, 3.0]
# Cost of the gaits at both commands (None: does not converge); survivors of 20 at both.
GAITS = ([100.0, 200.0], [110.0, 190.0], [100.0, None], [120.0, 200.0])
SURVIVE = ([20, 20], [20, 18], [19, 20])


def variant(name: str, factor: float, gaits: list[int], rollout: int | None, note: str = ""):
    return {
        "parameter": name,
        "provenance": "assumed",
        "unit": "N m",
        "nominal": "10",
        "factor": factor,
        "value": f"{10 * factor:g}",
        "note": note,
        "gaits": gaits,
        "rollout": rollout,
    }


SECTION = {
    "change": 0.2,
    "commands": COMMANDS,
    "robots": 20,
    "duration": 10.0,
    "skipped": ["body.nothing"],
    "nominal": {"gaits": [0, 1], "rollout": 0},
    "variants": [
        variant("drives.quiet", 0.8, [0, 1], 2),
        variant("drives.quiet", 1.2, [2, 3], 2),
        variant("drives.torque", 0.8, [4, 5], 0),
        variant("drives.torque", 1.2, [0, 1], 0),
        variant("body.mass", 0.8, [6, 7], 0),
        variant("body.mass", 1.2, [0, 1], 1),
        variant("leg.length", 0.8, [], None, "no such robot: expected a leg, found none"),
        variant("leg.length", 1.2, [0, 1], 0),
    ],
}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory) -> dict[str, list[Path]]:
    folder = tmp_path_factory.mktemp("sensitivity")
    gaits, rollouts = [], []
    for cost in (cost for pair in GAITS for cost in pair):
        gaits.append(folder / f"gait{len(gaits)}")
        gaits[-1].mkdir()
        report = {"converged": cost is not None, "iterations": 25, "cost": cost or 7.0}
        (gaits[-1] / "report.json").write_text(json.dumps(report))
    for pair in SURVIVE:
        rollouts.append(folder / f"rollout{len(rollouts)}")
        for command, count in zip(COMMANDS, pair, strict=True):
            alive = [[1] * count + [0] * (20 - count)]
            table = make_robots(alive, [[0.1] * 20])
            write_evaluation(rollouts[-1] / f"{command:g}", command, table)
    return {"gaits": gaits, "rollouts": rollouts}


@pytest.fixture(scope="module")
def out(inputs, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("out")
    assert run(SECTION, inputs, folder, Job(folder)) == {"parameters": 4, "carrying": 2}
    return folder


def table(folder: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((folder / "sensitivity.csv").read_text().splitlines()))


def test_a_row_per_robot_and_command(out):
    found = table(out)
    assert tuple(found[0]) == COLUMNS
    assert len(found) == 2 * (1 + 8)
    keys = [(row["parameter"], row["factor"], row["command"]) for row in found]
    assert keys[:4] == [
        ("nominal", "1", "1.2"),
        ("nominal", "1", "3"),
        ("drives.quiet", "0.8", "1.2"),
        ("drives.quiet", "0.8", "3"),
    ]


def test_costs_are_relative_to_the_unchanged_robot_at_the_same_command(out):
    found = {(r["parameter"], r["factor"], r["command"]): r for r in table(out)}
    assert float(found["drives.quiet", "1.2", "1.2"]["gait_cost_change"]) == pytest.approx(0.1)
    assert float(found["drives.quiet", "1.2", "3"]["gait_cost_change"]) == pytest.approx(-0.05)
    lost = found["drives.torque", "0.8", "3"]
    assert (lost["gait_converged"], lost["gait_cost"], lost["gait_cost_change"]) == ("0", "", "")
    assert lost["gait_iterations"] == "25"


def test_a_robot_that_cannot_be_has_a_note_and_no_numbers(out):
    row = next(r for r in table(out) if r["parameter"] == "leg.length" and r["factor"] == "0.8")
    assert row["note"] == "no such robot: expected a leg, found none"  # with its comma
    assert {row[name] for name in ("gait_converged", "gait_cost", "success_rate")} == {""}


def test_the_strongest_comes_first_and_who_carries_the_result(inputs):
    rows = read_rows(SECTION, inputs)
    found, nominal = effects(rows), nominals(rows)
    names = [effect.parameter for effect in found]
    assert names == ["drives.torque", "body.mass", "drives.quiet", "leg.length"]
    carry = carrying(found, nominal)
    assert [effect.parameter for effect in carry] == ["drives.torque", "body.mass"]
    assert carry[0].lost == [(0.8, 3.0)]
    assert carry[1].falls(nominal) == {(1.2, 3.0): 0.9}
    assert (found[2].cost, found[2].drop(nominal)) == pytest.approx((0.1, 0.05))


def test_the_verdict_is_in_plain_sentences(inputs):
    assert verdict(read_rows(SECTION, inputs)) == (
        "2 of 4 parameters carry the result: `drives.torque` and `body.mass`. "
        "The gait at 3.0 m/s does not converge with `drives.torque` × 0.8. "
        "At 3.0 m/s the policy survives in less than 95 % with `body.mass` × 1.2 (90 %). "
        "With the other 2 the gaits converge, and their cost changes by at most "
        "10 %, most with `drives.quiet` × 1.2 at 1.2 m/s. "
        "The policy survives with these in at least 95 %. "
        "There is no robot with `leg.length` × 0.8; the reason stands below."
    )


def test_where_nothing_falls_the_verdict_says_so(inputs):
    section = SECTION | {"variants": SECTION["variants"][:2]}
    found = verdict(read_rows(section, inputs))
    assert found.startswith("No parameter of 1 carries the result. With all of them the gaits")


def test_a_gait_that_the_unchanged_robot_has_not_is_no_loss(inputs):
    section = SECTION | {"nominal": {"gaits": [4, 5], "rollout": 0}}
    rows = read_rows(section, inputs)
    assert not any(effect.lost for effect in effects(rows))
    assert "The gait of the unchanged robot does not converge at 3.0 m/s" in verdict(rows)


@pytest.mark.parametrize(("nominal", "least"), [(1.0, 0.95), (0.95, 0.95), (0.5, 0.45), (0, 0)])
def test_a_policy_that_already_falls_has_a_lower_limit(nominal, least):
    assert limit(nominal) == pytest.approx(least)


def test_the_page_has_the_strongest_and_what_was_skipped(out):
    text = (out / "sensitivity.md").read_text()
    assert "| `drives.torque` | 10 N m | +0.0 % / +0.0 % | ✗ / +0.0 % | 100 % / 100 % |" in text
    assert "1 of value zero were left out (`body.nothing`)." in text
    assert "* `leg.length` × 0.8: no such robot: expected a leg, found none" in text


@pytest.mark.parametrize("absent", ["gaits", "rollouts"])
def test_one_of_both_is_enough(inputs, tmp_path, absent):
    made = {"gaits": []} if absent == "gaits" else {"rollout": None}
    section = SECTION | {
        "nominal": SECTION["nominal"] | made,
        "variants": [item | made for item in SECTION["variants"]],
    }
    run(section, inputs | {absent: []}, tmp_path, Job(tmp_path))
    column = "gait_cost" if absent == "gaits" else "success_rate"
    assert {row[column] for row in table(tmp_path)} == {""}


def test_same_input_same_bytes(out, inputs, tmp_path):
    run(SECTION, inputs, tmp_path, Job(tmp_path))
    names = {path.name for path in out.iterdir()}
    assert names == {f"sensitivity.{suffix}" for suffix in ("csv", "md", "svg", "png")}
    for name in names:
        assert (tmp_path / name).read_bytes() == (out / name).read_bytes(), name
