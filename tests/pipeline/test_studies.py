"""Jobs of the studies: equal ones are shared, one thing differs, laid out only when asked for."""

from pathlib import Path

import pytest

from pipeline.entry import open_pipeline
from pipeline.stages import table1_jobs
from pipeline.stages.evaluation import speed_of
from pipeline.studies import GAITS_ONLY, study_job
from slider.artefacts.plan import JobSpec, build_plan
from slider.config.parameters import choose, parameters, scaled
from slider.core.errors import UserError
from slider.core.files import flatten
from slider.robot.bodies import own_bodies, total_mass
from slider.robot.mjcf import SimulationOptions, build_spec
from tests.config.composed import CONF, composed

pytestmark = pytest.mark.usefixtures("constant_code")
TEST = "experiment=test"


def study(name: str, *overrides: str, experiment: str = TEST) -> JobSpec:
    given = [experiment, *overrides]
    config = composed(*given)
    return study_job(name, config, table1_jobs(config), given, CONF)


def keyed(job: JobSpec, group: str) -> dict[tuple, JobSpec]:
    return {
        tuple(key): made
        for key, made in zip(job.section["keys"][group], job.inputs[group], strict=True)
    }


def samples(job: JobSpec) -> list[int]:
    trainings = [walking.section["train"] for walking in job.inputs["walking"]]
    return [t["iterations"] * t["robots"] * t["steps_per_iteration"] for t in trainings]


def test_each_seed_of_a_variant_has_a_training_and_an_evaluation_per_speed():
    job = study("ablation")
    walking, evaluations = keyed(job, "walking"), keyed(job, "evaluations")
    runs = [(v, s) for v in ("default", "without_pretraining") for s in (1, 2)]
    assert [key[:2] for key in walking] == runs
    assert [*evaluations] == [(*run, speed) for run in runs for speed in (0.2, 0.4)]
    for (variant, seed, speed), made in evaluations.items():
        assert speed_of(made) == speed
        assert made.section["evaluation"]["robots"] == 3
        assert made.inputs["walking"] == [walking[variant, seed, 128]]
        assert made.inputs["walking"][0].section["train"]["seed"] == seed
    starts = [{"library", "start"}] * 2 + [{"library"}] * 2
    assert [set(made.inputs) for made in job.inputs["walking"]] == starts
    assert set(samples(job)) == {384}
    stages = [made.stage for made in build_plan({"": job}).jobs.values()]
    found = {name: stages.count(name) for name in ("gait", "library", "standing", "walking")}
    assert found == {"gait": 2, "library": 1, "standing": 2, "walking": 4}  # shared where equal


def test_other_controllers_walk_the_gaits_of_each_variant_in_rows_of_their_own():
    run = "study.ablation.run=[default,without_reference_starts]"
    names = ("policy", "policy_onboard", "hzd", "mpc_wbc_tuned")
    job = study("ablation", run, f"+study.ablation.evaluation.controllers=[{','.join(names)}]")
    found = keyed(job, "evaluations")
    variants = ("default", "without_reference_starts")
    rows = {v if name == "policy" else f"{v}_{name}": name for v in variants for name in names}
    assert {key[0]: made.section["controller"] for key, made in found.items()} == rows
    assert {row for row, *_ in job.section["variants"]} == {*rows}
    assert {key[1] for key in found if rows[key[0]] in names[:2]} == {1, 2}
    assert found["default_hzd", "", 0.2].inputs["library"][0].stage == "library"
    assert found["default_mpc_wbc_tuned", "", 0.2].inputs == {}
    with pytest.raises(
        UserError, match=r"evaluation\.controllers: expected one of policy, .*, found x"
    ):
        study("ablation", run, "+study.ablation.evaluation.controllers=[x]")


def test_variants_train_on_as_many_samples_whatever_their_batch():
    run = ("study.ablation.run=[default,paper]", "study.ablation.training.seeds=[1]")
    assert samples(study("ablation", *run, experiment="experiment=default")) == pytest.approx(
        [5406720] * 2, rel=0.01
    )


def test_one_of_the_seeds_is_the_pipeline_s_own_policy():
    own, seeds = table1_jobs(composed()), study("seeds", experiment="experiment=default")
    assert own["walking"].recipe in {made.recipe for made in seeds.inputs["walking"]}
    rows = {made.recipe for made in own["table1"].inputs["evaluations"]}
    found = {made.recipe for made in seeds.inputs["evaluations"]}
    assert len(found) == 5 * 7
    assert len(found & rows) == 7
    ablation = study("ablation", "study.ablation.run=[default]", experiment="experiment=default")
    trained = {made.recipe for made in ablation.inputs["walking"]}
    assert trained <= {made.recipe for made in seeds.inputs["walking"]}, "trained once for both"


@pytest.fixture(scope="module")
def everything() -> JobSpec:
    """All assumed numbers of the robot."""
    return study("sensitivity", "study.sensitivity.scaling.parameters=[]")


def test_every_assumed_number_has_two_variants_but_zeros(everything):
    assumed = choose(parameters(composed(TEST).robot), ["assumed"], [])
    varied = [item for item in assumed if any(item.value)]
    assert len(varied) < len(assumed)
    nominal, lighter, *others = everything.section["variants"]
    assert (nominal[0], lighter[0]) == ("nominal", "lighter")
    names, _, changes, notes = zip(*others, strict=True)
    assert [*names] == [f"{item.path}*{factor}" for item in varied for factor in (0.8, 1.2)]
    evaluated = {key[0] for key in keyed(everything, "evaluations")}
    unnoted = (n for n, note in zip(names, notes, strict=True) if not note)
    assert evaluated == {"nominal", "lighter", *unnoted}
    assert "robot.links.base.inertia=[0.036,0.0216,0.0336]" in changes


def test_a_job_differs_in_its_parameter_alone_and_is_shared_where_it_has_no_effect(everything):
    """Gaits do not use the gains of the position loop, rollouts not the virtual knee."""
    shared = 0
    for group in ("gaits", "evaluations"):
        jobs = keyed(everything, group)
        for (variant, seed, speed), made in jobs.items():
            path, nominal = variant.partition("*")[0], jobs["nominal", seed, speed]
            if variant in ("nominal", "lighter"):
                continue
            own, others = flatten(made.section), flatten(nominal.section)
            assert {name for name in others if own[name] != others[name]} <= {f"robot.{path}"}
            assert made.inputs == nominal.inputs
            unused = path.partition(".")[0] in GAITS_ONLY and group == "evaluations"
            used = f"robot.{path}" in others and not unused
            assert (made.recipe != nominal.recipe) == used, variant
            shared += not used
    assert shared > 0


def test_the_simulated_robot_has_no_part_that_only_gaits_use():
    robot = composed().robot
    options = SimulationOptions(0.005, 10, 10)
    before = build_spec(robot, options).to_xml()
    for item in parameters(robot):
        if item.path.partition(".")[0] in GAITS_ONLY:
            assert build_spec(scaled(robot, item.path, 1.2), options).to_xml() == before


def test_the_lighter_robot_weighs_as_its_label_says(everything):
    _, label, changes, _ = everything.section["variants"][1]
    robot = composed(*changes.split()).robot
    assert label == f"{total_mass(own_bodies(robot)):.1f} kg"


def test_a_robot_that_cannot_be_built_is_a_row_with_a_note():
    """A thigh of half its length: thigh and shank do not reach the ankle."""
    key = "study.sensitivity.scaling"
    job = study("sensitivity", f"{key}.parameters=[virtual_knee.thigh_length]", f"{key}.change=0.5")
    *_, short, long = job.section["variants"]
    assert short[3].startswith("invalid robot: robot.virtual_knee: expected thigh + shank")
    assert "\n" not in short[3]
    assert long[3] == ""
    assert {key[0] for key in keyed(job, "gaits")} == {"nominal", "lighter", long[0]}


def test_other_robots_have_gaits_a_training_and_evaluations_of_their_own(monkeypatch):
    monkeypatch.chdir(CONF.parent)  # their files are named from there
    job = study("robots", experiment="experiment=smoke")
    rows = keyed(job, "evaluations")
    names = {v: made.section["robot"]["name"] for (v, seed, _), made in rows.items() if seed}
    names = {v: name for v, name in names.items() if not v.endswith("_onboard")}
    assert {"bruce": "BRUCE", "unitree_g1_sole": "Unitree G1 with soles"}.items() <= names.items()
    assert len({*names.values()}) == len(names) == 9
    assert {key[0] for key in keyed(job, "gaits")} == names.keys()
    assert samples(job) == [1843200] * len(names)


def test_no_study_is_in_the_plan_until_it_is_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    own = "+study.mine=${study.gait_convergence}"
    opened = open_pipeline({"hydra": f"{TEST} '{own}'"}, CONF)
    before = dict(opened.plan.jobs)
    assert not opened.config.study.keys() & opened.plan.targets.keys()
    manifests = {name: opened.manifest(name)(None) for name in ("mine", "seeds", "ablation")}
    for name, manifest in manifests.items():
        assert Path(manifest).stem == opened.plan.targets[name]
        assert Path(f"artefacts/current/{name}").is_file()
        assert f"reports/{name}.csv" in opened.reports[name]
    assert "reports/mine_curves.csv" not in opened.reports["mine"]
    assert before.keys() < opened.plan.jobs.keys()
    assert str(opened.plan_path) in opened.run
    assert [*Path("artefacts/plans").iterdir()] == [opened.plan_path], "one plan per call"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("ablation.metrics=[cost]", "study.ablation.metrics: expected one of success_rate, "),
        ("ablation.variants.default.overrides=['a=1']", "study.ablation.variants.default: unknown"),
        (
            "ablation.variants.default.overrides=['+env.observation.terms.nose=1.0']",
            "study.ablation.variants.default: env.observation.terms: expected some of",
        ),
        (
            "ablation.variants.default.overrides=['finetuning=robust']",
            "study.ablation.training: expected variants without finetuning, found default",
        ),
        ("sensitivity.scaling.parameters=[legs]", "numbers of the robot tagged assumed, found leg"),
        (
            "sensitivity.scaling={change: 0.2, provenance: [measured], parameters: []}",
            "study.sensitivity.scaling: expected numbers of the robot tagged measured, found none",
        ),
    ],
)
def test_a_mistake_is_one_line_that_names_it(override, message):
    name = override.partition(".")[0]
    with pytest.raises(UserError) as error:
        study(name, f"study.{override}")
    assert message in str(error.value)
    assert "\n" not in str(error.value)
