"""The ablation's jobs: shared where equal, of equal length, laid out only when asked for."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from pipeline.ablation import ablation_job
from pipeline.entry import open_pipeline
from pipeline.stages import entries, table1_jobs
from slider.artefacts.plan import JobSpec, build_plan
from slider.artefacts.recipe import Code
from slider.config.compose import compose
from slider.core.errors import UserError

CONF = Path(__file__).parents[2] / "conf"


@pytest.fixture(scope="module", autouse=True)
def _constant_code():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(entries, "code_of", lambda entry: Code(entry, "source", {}))
        yield


def ablation(*overrides: str) -> JobSpec:
    given = ["experiment=test", *overrides]
    config = compose(given, CONF)
    return ablation_job(config, table1_jobs(config)["library"], given, CONF)


def stages(job: JobSpec) -> list[str]:
    return [item.stage for item in build_plan({"": job}).jobs.values()]


@pytest.fixture(scope="module")
def two() -> JobSpec:
    return ablation()


def samples(job: JobSpec) -> Iterator[int]:
    for walking in job.inputs["walking"]:
        train = walking.section["train"]
        yield train["iterations"] * train["robots"] * train["steps_per_iteration"]


def test_every_run_has_a_training_and_an_evaluation_per_command(two):
    runs = [(run["variant"], run["seed"]) for run in two.section["runs"]]
    assert runs == [(v, s) for v in ("default", "without_pretraining") for s in (1, 2)]
    walking, evaluations = two.inputs["walking"], two.inputs["evaluations"]
    assert [job.section["train"]["seed"] for job in walking] == [1, 2, 1, 2]
    for index, job in enumerate(evaluations):
        assert job.section["command"] == two.section["commands"][index % 2]
        assert job.inputs["walking"] == [walking[index // 2]]
        assert job.section["evaluation"]["robots"] == 3
    assert [set(job.inputs) for job in walking] == [{"library", "start"}] * 2 + [{"library"}] * 2
    assert set(samples(two)) == {384}


def test_what_variants_have_in_common_is_done_once(two):
    found = stages(two)
    assert found.count("gait") == 2
    assert (found.count("library"), found.count("standing"), found.count("walking")) == (1, 2, 4)


def test_a_run_that_is_the_pipeline_s_own_is_not_repeated():
    """With the samples of the experiment, its own seed of the default variant is its policy."""
    settings = (
        "ablation.samples=384",
        "ablation.pretraining_samples=256",
        "ablation.check_every=256",
        "train.standing.selection.interval=2",
    )
    config = compose(["experiment=test", *settings], CONF)
    own, seed = table1_jobs(config)["walking"].recipe, config.train.walking.seed
    assert ablation(*settings, f"ablation.seeds=[{seed}]").inputs["walking"][0].recipe == own


def test_the_seeds_are_those_of_table_1():
    """One of them is the pipeline's own policy, with its own evaluations."""
    given = ["ablation=seeds"]
    config = compose(given, CONF)
    own = table1_jobs(config)
    seeds = ablation_job(config, own["library"], given, CONF)
    place = config.ablation.seeds.index(config.train.walking.seed)
    assert seeds.inputs["walking"][place].recipe == own["walking"].recipe
    rows = {job.recipe for job in own["table1"].inputs["evaluations"]}
    found = [job.recipe for job in seeds.inputs["evaluations"]]
    assert set(found[7 * place : 7 * (place + 1)]) <= rows
    assert len(set(found)) == 3 * 7


def test_all_variants_train_on_as_many_samples():
    """Whatever the batch of an iteration; the paper's has another size."""
    job = ablation(
        "ablation.run=[default,paper]",
        "ablation.seeds=[1]",
        "experiment=default",
        "ablation.samples=4000000",
    )
    default, paper = samples(job)
    assert default == pytest.approx(4e6, rel=0.01)
    assert paper == pytest.approx(4e6, rel=0.01)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("gait.dynamics=knee", "env.action.offset: expected none of the family hzd with"),
        ("env/phase=fixed", "env.phase: expected no step_time and no halt"),
        (
            "+control.hzd.observer={delay:0.0,position:0.5,velocity:0.5}",
            "control.hzd.observer: expected null below actions",
        ),
    ],
)
def test_actions_on_a_controller_that_cannot_be_are_refused(override, message):
    with pytest.raises(UserError, match=message):
        table1_jobs(compose(["experiment=test", "env.action.offset=hzd", override], CONF))


def test_a_mistake_in_a_variant_names_it():
    with pytest.raises(UserError, match=r"ablation\.variants\.curriculum: .*growth: expected"):
        ablation(
            "ablation.run=[curriculum]",
            'ablation.variants.curriculum.overrides=["train.walking.commands.curriculum.growth=-1"]',
        )


def test_the_plan_has_no_ablation_until_somebody_asks(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    opened = open_pipeline({"hydra": "experiment=test"}, CONF)
    before = dict(opened.plan.jobs)
    assert "ablation" not in opened.plan.targets
    assert not Path("artefacts/current/ablation").exists()
    manifest = opened.manifest("ablation")(None)
    assert Path(manifest).stem == opened.plan.targets["ablation"]
    assert Path("artefacts/current/ablation").is_file()
    assert before.keys() < opened.plan.jobs.keys()
    assert str(opened.plan_path) in opened.run


def test_the_seeds_stand_beside_the_ablation(tmp_path, monkeypatch):
    """Both can be asked for at once; `seeds` is the default alone, whatever the ablation runs."""
    monkeypatch.chdir(tmp_path)
    opened = open_pipeline({"hydra": "experiment=test"}, CONF)
    manifests = {opened.manifest("ablation")(None), opened.manifest("seeds")(None)}
    assert len(manifests) == 2
    seeds = opened.plan.jobs[opened.plan.targets["seeds"]]
    assert seeds.section["name"] == "seeds"
    assert {run["variant"] for run in seeds.section["runs"]} == {"default"}


def test_the_papers_method_is_an_ablation_at_the_commands_of_table_1(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    opened = open_pipeline({}, CONF)
    opened.manifest("paper_method")(None)
    found = opened.plan.jobs[opened.plan.targets["paper_method"]]
    assert [run["variant"] for run in found.section["runs"]] == ["paper", "paper_alive"]
    assert found.section["commands"] == opened.config.speeds.table1
