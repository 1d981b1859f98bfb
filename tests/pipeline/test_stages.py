"""The stage graph: which value of the configuration reaches which recipe."""

from functools import cache

import pytest

from pipeline.stages import all_jobs, table1_jobs
from pipeline.stages.evaluation import baseline_tuning, gauge_job, protocol_jobs, second_engine
from pipeline.stages.gaits import gait, gait_section, library_job, velocities
from pipeline.stages.page import report
from pipeline.studies import study_job
from slider.artefacts.plan import JobSpec, build_plan
from slider.core import machine
from slider.core.errors import UserError
from tests.config.composed import CONF, composed

pytestmark = pytest.mark.usefixtures("constant_code")
ALL = {"gait", "library", "standing", "walking", "evaluation", "table1"}
AFTER_STANDING = {"standing", "walking", "evaluation", "table1"}
PROTOCOLS = {"baselines", "sweep", "robust", "onboard", "joystick", "heldout"}
AXES = {"slope_up", "delay", "push"}


@cache
def recipes(*overrides: str) -> dict[str, set[str]]:
    jobs = build_plan(jobs_of(*overrides)).jobs.values()
    return {stage: {job.recipe for job in jobs if job.stage == stage} for stage in ALL}


@cache
def protocols(*overrides: str) -> dict[str, str]:
    config = composed("experiment=test", *overrides)
    jobs = protocol_jobs(config, table1_jobs(config))
    return {name: job.recipe for name, job in jobs.items()}


@cache
def axes(*overrides: str) -> dict[str, str]:
    return {cell.section["axis"]: cell.recipe for cell in gauge(*overrides).inputs["cells"]}


@pytest.mark.parametrize(
    ("made", "override", "changed"),
    [
        (recipes, "gait.contact.friction=0.5", ALL),
        (recipes, "robot.links.tube.mass=1.0", ALL),
        (recipes, "robot.gains.capstan.kp=2.2", AFTER_STANDING),
        (recipes, "robot.contact.friction=0.8", AFTER_STANDING),
        (recipes, "library.max_violation=1e-5", ALL - {"gait"}),
        (recipes, "env.action.clip=3.0", AFTER_STANDING),
        (recipes, "train.walking.iterations=4", {"walking", "evaluation", "table1"}),
        (recipes, "train.walking.seed=4", {"walking", "evaluation", "table1"}),
        (recipes, "evaluation.trials=3", {"evaluation", "table1"}),
        (recipes, "evaluation.speeds=[0.4,0.2]", {"table1"}),
        (recipes, "protocols.sweep.trials=3", set()),
        (recipes, "resources.threads=1", set()),
        (recipes, "tracking.enabled=false", set()),
        (recipes, "robot.provenance.gains=paper", set()),
        (protocols, "protocols.sweep.trials=3", {"sweep"}),
        (protocols, "protocols.joystick.profile.warm_up=0.1", {"joystick"}),
        (protocols, "protocols.heldout.duration=1.4", {"heldout"}),
        (protocols, "evaluation.trials=3", set()),
        (protocols, "train.walking.seed=4", PROTOCOLS - {"baselines"}),
        (axes, f"gauge.scales.delay={[0.005, *(k / 100 for k in range(2, 11))]}", {"delay"}),
        (axes, "gauge.directions=8", {"push"}),
        (axes, "gauge.survival=0.8", set()),
        (axes, "gauge.robots=3", AXES),
        (axes, "train.walking.seed=4", AXES),
        (axes, "evaluation.trials=3", set()),
    ],
)
def test_a_value_reaches_what_depends_on_it(made, override, changed):
    before, after = made(), made(override)
    assert {name for name in before if before[name] != after[name]} == changed


def test_the_exported_policy_follows_the_training_and_is_not_on_the_way_to_table_1():
    plans = [build_plan(all_jobs(composed(*o))) for o in ([], ["train.walking.seed=4"])]
    assert plans[0].targets["policy_export"] != plans[1].targets["policy_export"]
    way = build_plan({"": plans[0].jobs[plans[0].targets["table1"]]}).jobs.values()
    assert "policy_export" not in {job.stage for job in way}


def test_a_case_is_a_job_that_does_not_know_of_the_others():
    before = cases()
    assert list(before) == ["0.3 m/s", "stop from 0.2 m/s"]
    one = "{name: 0.3 m/s, segments: [{name: walk, time: 0.0, vx: 0.3}]}"
    other = "{name: 0.5 m/s, segments: [{name: walk, time: 0.0, vx: 0.5}]}"
    after = cases(f"protocols.heldout.profile.cases=[{other},{one}]")
    assert after["0.3 m/s"] == before["0.3 m/s"]
    assert after["0.5 m/s"] not in before.values()
    moved = cases("protocols.heldout.profile.warm_up=0.3")
    assert not set(moved.values()) & set(before.values())


def cases(*overrides: str) -> dict[str, str]:
    """Recipe of each case of the protocol ``heldout``."""
    config = composed("experiment=test", *overrides)
    jobs = protocol_jobs(config, table1_jobs(config))["heldout"].inputs["evaluations"]
    return {job.section["case"]["name"]: job.recipe for job in jobs}


def test_a_wider_grid_keeps_its_gaits():
    before, after = recipes()["gait"], recipes("gait.grid.vx.stop=0.6")["gait"]
    assert before < after
    assert len(after - before) == 1


@pytest.mark.parametrize(
    ("velocity", "anchor"),
    [
        ((0.35, -0.1, 0.0), (0.4, 0.0, 0.0)),
        ((-0.05, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((0.6, 0.0, -0.3), (0.6, 0.0, 0.0)),
        ((3.0, 0.1, 0.0), (3.0, 0.0, 0.0)),
    ],
)
def test_a_gait_starts_from_that_of_the_nearest_anchor_whatever_the_grid(velocity, anchor):
    shared = gait_section(composed())
    (start,) = gait(shared, velocity).needs
    assert start.section["velocity"] == [*anchor]
    assert start.recipe == gait(shared, anchor).recipe
    assert not start.needs


@pytest.mark.parametrize("grid", ["paper", "extended", "omni", "wide"])
def test_each_grid_has_its_anchors(grid):
    library = library_job(composed(f"gait/grid={grid}"))
    assert len(build_plan({"": library}).jobs) == 1 + len(library.inputs["gaits"])


def test_grids_share_their_velocities():
    paper = velocities(composed("gait/grid=paper").gait.grid)
    extended = velocities(composed("gait/grid=extended").gait.grid)
    assert len(paper) == len(set(paper)) == 125
    assert paper == sorted(paper)
    assert set(paper) < set(extended)
    assert (0.15, -0.05, 0.0) in paper  # exactly, not 0.15000000000000002
    assert not any(str(value) == "-0.0" for velocity in paper for value in velocity)
    omni = velocities(composed("gait/grid=omni").gait.grid)
    assert len(omni) == 210
    assert {(-0.6, 0.3, -0.3), (1.2, -0.3, 0.3), (0.0, 0.0, 0.0)} < set(omni)


def jobs_of(*overrides: str) -> dict[str, JobSpec]:
    return table1_jobs(composed("experiment=test", *overrides))


CONTROLLERS = "evaluation.controllers=[policy,hzd,mpc_wbc_tuned]"


def everything(*overrides: str) -> list[JobSpec]:
    """All jobs, those of studies and of the gauge included."""
    given = ["experiment=test", "report.video.renderer=egl", CONTROLLERS, *overrides]
    config = composed(*given)
    targets = all_jobs(config)
    studies = [study_job("gait_starts", config, targets, given, CONF)]
    searches = baseline_tuning(config, targets)
    on_demand = [gauge_job(config, targets), searches, *studies, report(config, targets)]
    made = enumerate([*targets.values(), *on_demand])
    return list(build_plan({str(number): job for number, job in made}).jobs.values())


def test_kernels_and_precision_are_in_the_recipes_whose_bytes_depend_on_them(processor):
    stages, precisions = [], []
    for flags in ("avx2 fma", "avx2 fma avx512_bf16"):
        processor(flags)
        jobs = everything()
        stages.append({job.stage for job in jobs if "numerics" in job.section})
        precisions.append(jobs_of()["walking"].section["train"]["ppo"]["precision"])
        found = {job.section["numerics"] for job in jobs if "numerics" in job.section}
        assert found == {machine.kernels()}
    of_arrays = {"gait", "gait_start", "baseline", "tuning", "gait_walks", "verification_gaits"}
    of_arrays |= {"stability_gaits"}
    of_networks = {"standing", "walking", "evaluation", "gauge_axis", "video"}
    assert stages == 2 * [of_arrays | of_networks]
    assert precisions == ["float32", "bfloat16"]


GPU = ("train.walking.simulator=mujoco_warp", "train.walking.device=cuda")


def test_a_training_on_a_gpu_is_another_recipe_and_all_else_the_same():
    plain, own = jobs_of(), jobs_of(*GPU)
    for stage in ("standing", "walking"):
        train = own[stage].section["train"]
        assert (train["device"], train["ppo"]["precision"]) == ("cuda", "float32")
        assert plain[stage].section["train"]["device"] == "cpu"
        assert not {"warp", "mujoco_warp"} & plain[stage].code.versions.keys()
    assert own["library"].recipe == plain["library"].recipe
    sections = [made["walking"].section["env"] for made in (own, plain)]
    assert sections[0] == sections[1]


ALONE = (
    "env/phase=fixed",
    "env.action.offset=nominal",
    "train/walking/reward=unguided",
    "train.walking.reset.reference_fraction=0",
)


def test_a_training_without_library_or_pretraining_does_not_wait_for_them():
    assert set(jobs_of()["walking"].inputs) == {"library", "start"}
    assert set(jobs_of("train.pretraining=false")["walking"].inputs) == {"library"}
    assert "standing" not in jobs_of("train.pretraining=false")
    assert set(jobs_of(*ALONE)["walking"].inputs) == {"start"}
    assert set(jobs_of()["table1"].inputs) == {"evaluations", "library"}
    assert set(jobs_of(*ALONE)["table1"].inputs) == {"evaluations"}
    assert set(jobs_of(*ALONE)["standing"].inputs) == set()
    assert set(jobs_of(*ALONE, "train.pretraining=false")["walking"].inputs) == set()


def test_a_fine_tuning_follows_the_walking_training():
    """Its policy is what everything after it uses; the training before it is the shared one."""
    plain, tuned = jobs_of(), jobs_of("finetuning=robust")
    assert "untuned" not in plain
    assert tuned["untuned"].recipe == plain["walking"].recipe
    assert tuned["walking"].inputs["start"] == [tuned["untuned"]]
    assert tuned["walking"].recipe != plain["walking"].recipe
    for evaluation in tuned["table1"].inputs["evaluations"]:
        assert evaluation.inputs.get("walking", [tuned["walking"]]) == [tuned["walking"]]
    config = composed("experiment=test", "finetuning=robust", "report.video.renderer=none")
    inputs = report(config, all_jobs(config)).inputs
    labels = [job.label for job in (*inputs["untuned"], *inputs["walking"])]
    assert labels == ["walking", "fine-tuning"]


def test_gaits_of_the_virtual_knee_have_no_controller_that_enforces_them():
    with pytest.raises(UserError, match=r"evaluation\.controllers: expected none .* found hzd"):
        table1_jobs(composed("gait.dynamics=knee"))
    jobs = table1_jobs(composed("gait.dynamics=knee", "evaluation.controllers=[policy]"))
    assert "table1" in jobs
    with pytest.raises(UserError, match=r"^gauge\.controllers: expected none .* found hzd"):
        gauge("experiment=paper", "gauge.controllers=[policy,hzd_onboard]")


def test_the_second_engine_without_drake_is_one_line(monkeypatch):
    config = composed("experiment=test")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"^second_engine: expected Drake \(pip install .* none$"):
        second_engine(config, all_jobs(config))


def gauge(*overrides: str) -> JobSpec:
    config = composed("experiment=test", *overrides)
    return gauge_job(config, all_jobs(config))


def test_an_exported_policy_is_gauged_with_its_own_sensing(tmp_path):
    for name in ("policy.onnx", "policy.json"):
        (tmp_path / name).write_text(name)
    made = gauge("gauge.controllers=[o,o_onboard]", f"+gauge.policies.o={tmp_path}")
    assert made.section["labels"] == {"o": "o", "o_onboard": "o, onboard state"}
    sensing = {cell.section["controller"]: cell.section["env"] for cell in made.inputs["cells"]}
    assert [env["sensing"] for env in sensing.values()] == ["true_state", "onboard"]
    assert all(set(cell.inputs) == {"policy"} for cell in made.inputs["cells"])
    (tmp_path / "policy.json").write_text("another")
    other = gauge("gauge.controllers=[o,o_onboard]", f"+gauge.policies.o={tmp_path}")
    assert not {c.recipe for c in made.inputs["cells"]} & {c.recipe for c in other.inputs["cells"]}


def test_a_label_that_two_rows_would_have_is_refused():
    rows = "evaluation.controllers=[hzd_onboard,mpc_wbc_tuned]"
    label = "control.mpc_wbc_tuned.label='HZD, onboard state'"
    with pytest.raises(UserError, match=r"label: expected a unique label, found HZD, onboard"):
        all_jobs(composed(rows, label))
