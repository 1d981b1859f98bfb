"""The study of the gait optimisation: independent jobs, and only new ones are solved."""

from pathlib import Path

import pytest

from pipeline.entry import open_pipeline
from pipeline.gait_study import gait_study_job
from pipeline.stages import entries, table1_jobs
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import Code
from slider.config.compose import compose
from slider.core.errors import UserError
from tests.workflow.workspace import copy_repository

CONF = Path(__file__).parents[2] / "conf"
TARGET = "reports/gait_convergence.csv"


@pytest.fixture(scope="module", autouse=True)
def _constant_code():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(entries, "code_of", lambda entry: Code(entry, "source", {}))
        yield


def study(*overrides: str) -> JobSpec:
    return gait_study_job(compose(["experiment=test", *overrides], CONF))


def recipes(job: JobSpec, name: str) -> list[str]:
    return [each.recipe for each in job.inputs[name]]


def test_every_mesh_and_every_start_is_a_job():
    job = study("gait_study.commands=[0.4,1.2]")
    meshes = [
        (j.section["command"][0], j.section["formulation"]["nodes"]) for j in job.inputs["meshes"]
    ]
    assert meshes == [(0.4, 5), (0.4, 7), (1.2, 5), (1.2, 7)]
    starts = [(j.section["command"][0], j.section["start"]["index"]) for j in job.inputs["starts"]]
    assert starts == [(0.4, 0), (0.4, 1), (1.2, 0), (1.2, 1)]
    assert len({*recipes(job, "meshes"), *recipes(job, "starts")}) == 8


def test_more_starts_leave_the_first_ones_alone():
    few, many = study(), study("gait_study.starts.number=5")
    assert recipes(many, "starts")[:2] == recipes(few, "starts")
    assert recipes(many, "meshes") == recipes(few, "meshes")
    assert not {*recipes(study("gait_study.starts.seed=2"), "starts")} & {*recipes(few, "starts")}


def test_the_library_s_mesh_is_solved_once():
    config = compose(["experiment=test", "gait_study.nodes=[5,21]"], CONF)
    job = gait_study_job(config)
    own = recipes(job, "library")
    assert own == [recipes(job, "meshes")[1]]
    assert own[0] in {gait.recipe for gait in table1_jobs(config)["library"].inputs["gaits"]}


def test_the_plan_has_it_when_somebody_asks(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    opened = open_pipeline({"hydra": "experiment=test report.video.renderer=none"}, CONF)
    before = {*opened.plan.jobs}
    assert "gait_start" not in {job.stage for job in opened.plan.jobs.values()}
    opened.manifest("gait_convergence")(None)
    added = [job.stage for recipe, job in opened.plan.jobs.items() if recipe not in before]
    assert sorted(added) == ["gait", "gait", "gait_convergence", "gait_start", "gait_start"]


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("nodes=[11,20]", "gait_study.nodes[1]: expected an odd number, found 20"),
        ("nodes=[11,11]", "gait_study.nodes: expected each once"),
        ("nodes=[]", "gait_study.nodes: expected a list of one or more"),
        ("nodes=[3]", "gait_study.nodes[0]: expected an integer in [5, 201], an odd"),
        ("commands=[0.4,0.4]", "gait_study.commands: expected each once"),
        ("same_cost=0", "gait_study.same_cost: expected a number in (0, 1], found 0"),
        ("starts.number=0", "gait_study.starts.number: expected an integer in [1, 1e6], found 0"),
        ("starts.spread.joints=-0.1", "gait_study.starts.spread.joints: expected a number in (0, "),
        ("starts.spread.crouch.lower=2", "gait_study.starts.spread.crouch: expected lower ≤ upper"),
    ],
)
def test_nonsense_is_one_line(override, message):
    with pytest.raises(UserError) as error:
        compose([f"gait_study.{override}"], CONF)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.workflow
def test_only_new_starts_are_solved(tmp_path):
    workspace = copy_repository(tmp_path / "copy")
    found = workspace.computed(target=TARGET)
    assert found == sorted([*["gait"] * 3, *["gait_start"] * 2, "gait_convergence"])
    reports = workspace.folder / "reports"
    assert len((workspace.folder / TARGET).read_text().splitlines()) == 1 + 2
    assert len((reports / "gait_starts.csv").read_text().splitlines()) == 1 + 1 + 2
    assert "At 0.4 m/s" in (reports / "gait_convergence.md").read_text()
    assert (reports / "figures/gait_convergence.png").is_file()
    assert workspace.computed(target=TARGET) == []
    more = workspace.computed("gait_study.starts.number=3", target=TARGET)
    assert more == ["gait_convergence", "gait_start"]
