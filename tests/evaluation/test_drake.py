"""Drake's model of the robot: its audit finds what is changed, and robots stand and fall in it."""

import copy
from functools import partial

import numpy as np
import pytest

pytest.importorskip("pydrake", reason="Drake is not installed: pip install -e '.[drake]'")

from pipeline.stages import all_jobs
from pipeline.stages.evaluation import second_engine
from slider.config.convert import to_dict
from slider.config.evaluation import DrakeContact
from slider.core.errors import UserError
from slider.core.job import Job
from slider.env.disturbance import Disturbance
from slider.env.drake import DrakePhysics, DrakeRobot
from slider.env.physics import BatchedPhysics
from slider.env.starts import at_rest
from slider.evaluation import drake
from slider.evaluation.results import Evaluation
from slider.reports import second_engine as report
from slider.robot.mjcf import SimulationOptions, build_model, nominal_qpos
from tests.config.composed import composed
from tests.control.policies import write_policy
from tests.env.synthetic import config
from tests.evaluation.test_results import make_robots, write_evaluation
from tests.evaluation.test_stage import section

CONTACT = DrakeContact("lagged", 10.0)
DRAKE = {"timestep": 0.001, "contact": to_dict(CONTACT)}


@pytest.fixture(scope="module")
def model():
    whole = config()
    model = build_model(whole.robot, SimulationOptions.of(whole.env.physics))
    model.opt.timestep = DRAKE["timestep"]
    return model


def audit(model, built):
    return drake.audit(
        model, DrakeRobot(built, DRAKE["timestep"], CONTACT), nominal_qpos(config().robot)
    )


@pytest.mark.parametrize(
    ("field", "rows", "factor", "named"),
    [
        ("body_inertia", lambda m: m.body("left_foot").id, 1.01, "inertia of left_foot"),
        ("jnt_range", lambda m: m.joint("right_ankle").id, 1.01, "range of right_ankle"),
        ("jnt_axis", lambda m: m.joint("left_hip_roll").id, -1.0, "axis of left_hip_roll"),
        ("tendon_armature", lambda m: 0, 1.5, "armature of left_slide"),
        ("geom_friction", lambda m: m.geom("left_foot").id, 0.8, "friction of left_foot, heel"),
        (
            "wrap_prm",
            lambda m: m.wrap_objid == m.joint("right_slide").id,
            1.02,
            "motor torque of right_leg_1",
        ),
    ],
)
def test_the_audit_names_what_is_changed(model, field, rows, factor, named):
    changed = copy.copy(model)
    getattr(changed, field)[rows(model)] *= factor
    with pytest.raises(UserError, match=rf"[:;] {named} differs by"):
        audit(model, changed)


def test_motors_of_a_capstan_that_differ_are_refused(model):
    """Their inertia couples slide and ankle, which Drake's joints do not."""
    changed = copy.copy(model)
    changed.tendon_armature[0] *= 1.5
    with pytest.raises(UserError, match="armature of left_slide differs by"):
        audit(changed, changed)


def test_onboard_state_and_loads_are_those_of_mujoco(model):
    whole = config("env.sensing=onboard")
    starts = at_rest(whole.robot, whole.evaluation.start, np.random.default_rng(1), 2)
    seen = []
    for engine in (BatchedPhysics, partial(DrakePhysics, drake=DRAKE)):
        physics = engine(whole.robot, whole.env.physics, 2, onboard=whole.env.estimation)
        physics.restart_disturbances()
        physics.reset(np.arange(2), *starts)
        for _ in range(25):
            physics.step(np.tile(physics.nominal[7:], (2, 1)))
            measured = physics.measure(physics.read())
        load = physics.loads()
        seen.append((physics.qpos, measured.base_height, measured.foot_forces, load.effort_share))
    for mine, other, within in zip(*seen, (0.02, 3e-3, 5.0, 0.02), strict=True):
        np.testing.assert_allclose(mine, other, atol=within)


def test_a_robot_that_cannot_stand_falls_and_disturbed_ones_are_refused(tmp_path):
    whole = config("experiment=test")
    random = section(duration=2.0) | {"drake": DRAKE}
    write_policy(tmp_path / "policy.pt")
    (tmp_path / "out").mkdir()
    job = Job(tmp_path / "work")
    summary = drake.run(random, {"walking": [tmp_path]}, tmp_path / "out", job)
    assert summary["success_rate"] == 0.0
    assert not Evaluation.load(tmp_path / "out").robots["survived"].any()
    pushed = config("evaluation/disturbance=robust").evaluation.disturbance
    with pytest.raises(UserError, match=r"^Drake: disturbance: expected nominal robots"):
        DrakePhysics(
            whole.robot, whole.env.physics, 1, drake=DRAKE, disturbance=Disturbance(pushed, (0,))
        )


def test_engines_and_frictions_stand_side_by_side(tmp_path, model, constant_code):
    contacts = "second_engine.contacts=[{approximation:lagged,dissipation:10}]"
    whole = composed("experiment=test", "speeds.table1=[0.4]", contacts)
    made = second_engine(whole, all_jobs(whole))
    here, there, slippery, again = made.inputs["evaluations"]
    assert (here.stage, there.stage) == ("evaluation", "drake_evaluation")
    assert there.inputs == {**here.inputs, "audit": list(made.inputs["audits"])}
    assert there.section == {**here.section, "drake": DRAKE}
    assert [job.section["robot"]["contact"]["friction"] for job in (slippery, again)] == [0.3] * 2
    folders = [
        write_evaluation(tmp_path / str(number), 0.4, make_robots([[1, number < 3]], [[0.1, 0.2]]))
        for number in range(4)
    ]
    (tmp_path / "audit").mkdir()
    audited = dict(made.inputs["audits"][0].section)
    drake.run_audit(audited, {}, tmp_path / "audit", Job(tmp_path))
    inputs = {"evaluations": folders, "audits": [tmp_path / "audit"]}
    report.run(dict(made.section), inputs, tmp_path, Job(tmp_path))
    lines = (tmp_path / "second_engine.md").read_text().splitlines()
    assert "| Success rate [%] | policy (ours) | MuJoCo | 100 | 100 |" in lines
    assert "|  | policy (ours) | Drake, lagged, 10 s/m | 50 | 100 |" in lines
    assert any(line.startswith("| gravity torque | ") for line in lines)
