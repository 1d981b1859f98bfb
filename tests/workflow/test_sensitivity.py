"""The sensitivity's jobs: one parameter differs, what is not used is shared."""

from pathlib import Path

import pytest

from pipeline.entry import open_pipeline
from pipeline.sensitivity import GAITS_ONLY, sensitivity_job
from pipeline.stages import entries, table1_jobs
from pipeline.targets import all_targets
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import Code
from slider.config.compose import compose
from slider.config.parameters import choose, parameters, scaled
from slider.robot.mjcf import SimulationOptions, build_spec
from tests.workflow.workspace import finished

CONF = Path(__file__).parents[2] / "conf"


@pytest.fixture(scope="module", autouse=True)
def _constant_code():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(entries, "code_of", lambda entry: Code(entry, "source", {}))
        yield


def sensitivity(*overrides: str) -> JobSpec:
    config = compose(["experiment=test", *overrides], CONF)
    return sensitivity_job(config, table1_jobs(config)["walking"])


def only(*paths: str) -> str:
    return f"sensitivity.parameters=[{','.join(paths)}]"


@pytest.fixture(scope="module")
def everything() -> JobSpec:
    return sensitivity("sensitivity.parameters=[]")


def difference(one: object, other: object, path: str = "") -> set[str]:
    """Paths at which nested values differ."""
    if isinstance(one, dict) and isinstance(other, dict):
        names = one.keys() | other.keys()
        return set().union(
            *(difference(one.get(n), other.get(n), f"{path}.{n}".lstrip(".")) for n in names)
        )
    return set() if one == other else {path}


def test_every_assumed_number_has_two_rows_and_zeros_none(everything):
    found = parameters(compose(["experiment=test"], CONF).robot)
    assumed = choose(found, ["assumed"], [])
    rows = [(row["parameter"], row["factor"]) for row in everything.section["variants"]]
    assert rows == [(p.path, f) for p in assumed if not p.zero for f in (0.8, 1.2)]
    assert everything.section["skipped"] == [item.path for item in assumed if item.zero]
    assert {row["provenance"] for row in everything.section["variants"]} == {"assumed"}


def test_a_job_differs_in_its_parameter_alone(everything):
    """Of the whole section; the policy that rolls out is always the same input."""
    section = everything.section
    gaits, rollouts = everything.inputs["gaits"], everything.inputs["rollouts"]
    for row in section["variants"]:
        if row["note"]:
            continue
        expected = f"robot.{row['parameter']}"
        for place, nominal in zip(row["gaits"], section["nominal"]["gaits"], strict=True):
            assert difference(gaits[place].section, gaits[nominal].section) <= {expected}
        plant = rollouts[row["rollout"]]
        nominal = rollouts[section["nominal"]["rollout"]]
        assert difference(plant.section, nominal.section) <= {expected}
        assert plant.inputs == nominal.inputs


def has(node: object, path: str) -> bool:
    for name in path.split("."):
        if not isinstance(node, dict) or name not in node:
            return False
        node = node[name]
    return True


def test_what_a_stage_does_not_use_shares_the_unchanged_job(everything):
    """The gaits know no gains of the position loop, the simulated robot no virtual knee."""
    nominal = everything.section["nominal"]
    known = everything.inputs["gaits"][nominal["gaits"][0]].section["robot"]
    rows = [row for row in everything.section["variants"] if not row["note"]]
    for row in rows:
        used = has(known, row["parameter"])
        assert (row["gaits"] != nominal["gaits"]) == used, row["parameter"]
        simulated = row["parameter"].partition(".")[0] not in GAITS_ONLY
        assert (row["rollout"] != nominal["rollout"]) == simulated, row["parameter"]
    shared = sum(row["gaits"] == nominal["gaits"] for row in rows)
    assert 0 < shared < len(rows)
    assert len(everything.inputs["gaits"]) == 2 * (1 + len(rows) - shared)


def test_the_gaits_of_the_unchanged_robot_are_the_library_s():
    config = compose(["experiment=test"], CONF)
    jobs = table1_jobs(config)
    own = {gait.recipe for gait in jobs["library"].inputs["gaits"]}
    job = sensitivity_job(config, jobs["walking"])
    nominal = [job.inputs["gaits"][place].recipe for place in job.section["nominal"]["gaits"]]
    assert set(nominal) == own


def test_the_simulated_robot_has_no_part_that_only_gaits_know():
    """A change of it leaves the compiled model as it was."""
    robot = compose([], CONF).robot
    options = SimulationOptions(0.005, 10, 10)
    before = build_spec(robot, options).to_xml()
    for item in parameters(robot):
        if item.path.partition(".")[0] in GAITS_ONLY:
            assert build_spec(scaled(robot, item.path, 1.2), options).to_xml() == before


def test_a_robot_that_cannot_be_is_a_row():
    """A thigh of half its length: thigh and shank do not reach the ankle."""
    job = sensitivity(only("virtual_knee.thigh_length"), "sensitivity.change=0.5")
    short, long = job.section["variants"]
    assert short["note"].startswith("no such robot: robot.virtual_knee: expected thigh + shank")
    assert "\n" not in short["note"]
    assert (short["gaits"], short["rollout"]) == ([], None)
    assert long["note"] == ""
    assert len(long["gaits"]) == 2


def test_only_what_is_asked_for_is_planned():
    gaits, policy = sensitivity("sensitivity.policy=false"), sensitivity("sensitivity.gaits=false")
    assert (len(gaits.inputs["rollouts"]), len(policy.inputs["gaits"])) == (0, 0)
    assert gaits.inputs["gaits"]
    assert policy.inputs["rollouts"]


def test_values_and_units_are_told():
    row = sensitivity(only("links.base.inertia")).section["variants"][1]
    assert (row["nominal"], row["value"]) == ("0.03 0.018 0.028", "0.036 0.0216 0.0336")
    assert row["unit"] == "kg m²"


def test_the_plan_has_no_changed_robot_until_somebody_asks(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    opened = open_pipeline({"hydra": "experiment=test"}, CONF)
    before = dict(opened.plan.jobs)
    assert "sensitivity" not in opened.plan.targets
    manifest = opened.manifest("sensitivity")(None)
    assert Path(manifest).stem == opened.plan.targets["sensitivity"]
    assert before.keys() < opened.plan.jobs.keys()
    assert "ablation" not in opened.plan.targets
    opened.manifest("ablation")(None)
    assert {"ablation", "sensitivity"} <= opened.plan.targets.keys()


def test_the_page_does_not_depend_on_its_settings():
    def page(*overrides: str) -> str:
        given = ["experiment=test", "report.video.renderer=none", *overrides]
        return all_targets(compose(given, CONF), given, CONF)["report"].recipe

    assert page() == page("sensitivity.change=0.1")


@pytest.mark.workflow
def test_the_pipeline_makes_the_table(session_folder, tmp_path):
    """The policy of a finished pipeline, on changed robots; nothing of it is made anew."""
    workspace = finished(session_folder).copy(tmp_path / "copy")
    found = workspace.computed(target="reports/sensitivity.csv")
    assert found == sorted([*["gait"] * 8, *["sensitivity_policy"] * 3, "sensitivity"])
    reports = workspace.folder / "reports"
    assert len((reports / "sensitivity.csv").read_text().splitlines()) == 1 + 2 * (1 + 4)
    assert "Which guesses carry the result" in (reports / "sensitivity.md").read_text()
    assert (reports / "figures/sensitivity.png").is_file()
    assert workspace.computed(target="reports/sensitivity.csv") == []
