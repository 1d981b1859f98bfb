"""The evaluation stage on a tiny protocol, with a policy of random weights and the baseline."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from slider.config.convert import to_dict
from slider.config.evaluation import at_speed
from slider.config.parameters import scaled
from slider.control.model_based import build_plant
from slider.core.errors import UserError
from slider.core.job import Job
from slider.env.disturbance import Disturbance
from slider.env.physics import BatchedPhysics
from slider.env.starts import at_rest
from slider.evaluation import stage
from slider.evaluation.results import Evaluation
from slider.robot.mjcf import nominal_qpos
from tests.control.policies import write_policy
from tests.env.synthetic import config, stand

WHOLE = ("experiment=test", "evaluation.duration=0.6")
TRIALS, ROBOTS = 2, 3


def section(speed: float = 0.2, **changes) -> dict:
    whole = config(*WHOLE)
    return {
        "robot": to_dict(whole.robot),
        "env": to_dict(whole.env),
        "evaluation": to_dict(replace(whole.evaluation, **changes)),
        "controller": "policy",
        "case": to_dict(at_speed(speed)),
    }


@pytest.fixture(scope="module")
def walking(tmp_path_factory):
    """The folder of a walking stage; a small random policy."""
    folder = tmp_path_factory.mktemp("walking")
    write_policy(folder / "policy.pt")
    return folder


def run(walking, out, seconds: float = 0.6, speed: float = 0.2, **changes):
    out.mkdir()
    job = Job(out.parent / "work", threads=1)
    summary = stage.run(
        section(speed, duration=seconds, **changes), {"walking": [walking]}, out, job
    )
    return summary, Evaluation.load(out).robots


def test_summary_and_traces_are_those_of_the_robots(walking, tmp_path, rollouts):
    summary, table = run(walking, tmp_path / "out", seconds=0.4)
    np.testing.assert_array_equal(table["trial"], [0, 0, 0, 1, 1, 1])
    np.testing.assert_array_equal(table["robot"], [0, 1, 2, 0, 1, 2])
    assert summary["success_rate"] == table["survived"].mean()
    survivors = table["squared_error_steady"][table["survived"]]
    assert summary["mse_steady"] == pytest.approx(survivors.mean(), rel=1e-6)
    assert summary["diverged"] == 0
    recording = rollouts[0].recording
    forward = recording.velocity[:, recording.survived, 0]
    assert forward.shape[1] > 1
    expected = np.stack([forward.mean(axis=1), forward.std(axis=1)], axis=1)
    found = np.load(tmp_path / "out" / "velocity.npy")
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-7)
    assert np.ptp(found[:, 1]) > 0.0


def test_where_all_fall_there_are_no_errors(walking, tmp_path, recwarn):
    """A random policy does not stand for three seconds."""
    summary, table = run(walking, tmp_path / "out", seconds=3.0)
    assert not table["survived"].any()
    assert summary["success_rate"] == 0.0
    assert summary["mse_steady"] is None
    assert np.isnan(table["squared_error"]).all()
    assert np.isnan(np.load(tmp_path / "out" / "velocity.npy")).all()
    assert [str(w.message) for w in recwarn if w.category is RuntimeWarning] == []


@pytest.fixture
def rollouts(monkeypatch) -> list[SimpleNamespace]:
    """What the rollouts of a test were given, and their recordings."""
    seen, real = [], stage.roll_out

    def spying(controller, physics, env, start, command, *rest):
        found = real(controller, physics, env, start, command, *rest)
        of = {"start": start, "command": command, "recording": found}
        seen.append(SimpleNamespace(**of, controller=controller, physics=physics))
        return found

    monkeypatch.setattr(stage, "roll_out", spying)
    return seen


def test_a_trial_has_its_own_starts_whatever_the_command(walking, tmp_path, rollouts):
    run(walking, tmp_path / "slow", speed=0.2)
    run(walking, tmp_path / "fast", speed=3.0)
    run(walking, tmp_path / "later", speed=0.2, seed=config(*WHOLE).evaluation.seed + 1)
    slow, fast, later = (rollout.start for rollout in rollouts)
    np.testing.assert_array_equal(slow[0], fast[0])
    for rollout, speed in zip(rollouts, (0.2, 3.0), strict=False):
        np.testing.assert_array_equal(rollout.command[0], np.tile([speed, 0.0, 0.0], (6, 1)))
    np.testing.assert_array_equal(later[0][:ROBOTS], slow[0][ROBOTS:])  # trial k: seed + k
    whole = config(*WHOLE)
    rng = np.random.default_rng(whole.evaluation.seed)
    expected, _ = at_rest(whole.robot, whole.evaluation.start, rng, ROBOTS)
    np.testing.assert_array_equal(slow[0][:ROBOTS], expected)
    assert len(np.unique(slow[0][:, 8])) == TRIALS * ROBOTS
    assert not slow[1].any()


def test_policy_of_another_interface_is_one_line(walking, tmp_path):
    terms = section()["env"]["observation"]["terms"]
    fewer = {name: scale for name, scale in terms.items() if name != "phase"}
    for group, values, message in (
        ("observation", {"terms": fewer}, "terms.phase=1.0, as in its training, found nothing"),
        ("observation", {"terms": dict(reversed(terms.items()))}, "the observations "),
        ("action", {"offset": "nominal"}, "offset=gait, as in its training, found nominal"),
    ):
        other = section()
        other["env"][group] |= values
        with pytest.raises(UserError, match=rf"^policy: expected (env\.{group}\.)?{message}"):
            stage.run(other, {"walking": [walking]}, tmp_path, Job(tmp_path))


def test_a_changing_command_also_gives_segments_and_traces(walking, tmp_path):
    whole = config("experiment=test").protocols["joystick"]
    (case,) = whole.profile.cases
    values = section() | {"evaluation": to_dict(whole), "case": to_dict(case)}
    summary = stage.run(values, {"walking": [walking]}, tmp_path, Job(tmp_path))
    assert summary["speed"] is None
    found = Evaluation.load(tmp_path)
    assert found.case == case.name
    assert [*found.segments.groupby("segment").size()] == 2 * [whole.trials * whole.robots]
    assert found.traces.shape == (60, 10)
    np.testing.assert_allclose(found.traces[-1, :3], [0.4, 0.1, 0.3], atol=1e-7)


ROBUST = config("evaluation=robust").evaluation.disturbance


def test_disturbances_are_repeatable_and_belong_to_the_trial(walking, tmp_path):
    _, calm = run(walking, tmp_path / "calm")
    _, one = run(walking, tmp_path / "one", disturbance=ROBUST)
    run(walking, tmp_path / "again", disturbance=ROBUST)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes(), path.name
    _, first = run(walking, tmp_path / "first", disturbance=ROBUST, trials=1)
    key = "peak_effort"
    np.testing.assert_allclose(one[key][:ROBOTS], first[key], rtol=1e-4)  # another batch's rounding
    assert (one[key] != calm[key]).all()


def test_policy_and_baseline_meet_the_same_robots():
    """Same masses, whatever the drives and the control rate."""
    whole = config(*WHOLE, "evaluation=robust", "evaluation.trials=2", "evaluation.robots=3")
    test, count, control = whole.evaluation, 6, whole.control["mpc_wbc_tuned"]
    disturbance = Disturbance(test.disturbance, tuple(stage.seeds_of(test)))
    slow = BatchedPhysics(whole.robot, whole.env.physics, count, disturbance=disturbance)
    fast = build_plant(whole.robot, whole.env.plant, control, count, disturbance=disturbance)
    stand(slow), stand(fast)
    np.testing.assert_array_equal(slow.masses, fast.masses)
    assert len(np.unique(slow.masses)) == count


def test_on_another_robot_the_policy_keeps_its_own_model(walking, tmp_path, rollouts):
    """With a longer leg the plant stands and starts higher; the policy's nominal height stays."""
    robot = config("experiment=test").robot
    longer = scaled(robot, "geometry.leg_length", 1.05)
    for name, one in (("own", robot), ("long", longer)):
        (tmp_path / name).mkdir()
        values = section() | {"robot": to_dict(one)}
        stage.run(values, {"walking": [walking]}, tmp_path / name, Job(tmp_path))
    own, other = (rollout.start[0] for rollout in rollouts)
    np.testing.assert_allclose(own[:, 3:], other[:, 3:])  # the same noise
    assert (other[:, 2] - own[:, 2]).min() > 0.02
    physics, agent = rollouts[1].physics, rollouts[1].controller.agent
    assert physics.robot == longer
    height = nominal_qpos(robot)[2]
    assert physics.nominal[2] == pytest.approx(height + 0.05 * robot.geometry.leg_length)
    assert agent.nominal_height == height
    np.testing.assert_array_equal(agent.nominal, nominal_qpos(robot)[7:])


def baseline(controller: str = "mpc_wbc_tuned", **changes) -> dict:
    values, whole = section(**changes), config(*WHOLE)
    env = values.pop("env")
    plant = {name: env[name] for name in ("control_period", "physics", "termination")}
    control = to_dict(whole.control[controller])
    return values | {"plant": plant, "control": control, "controller": controller}


def test_the_baseline_walks_and_its_records_are_those_of_the_policy(tmp_path):
    """The literal settings take a command of 0.2 m/s as the speed at the end of a step."""
    controller = "mpc_wbc_literal"
    values = baseline(controller, duration=4.0, warm_up=2.4, robots=1)
    summary = stage.run(values, {}, tmp_path, Job(tmp_path))
    found = Evaluation.load(tmp_path)
    assert len(found.robots) == 2
    assert summary["success_rate"] == 1.0
    assert summary["controller"] == found.controller == controller
    np.testing.assert_allclose(found.robots["mean_velocity"], 0.167, atol=0.03)
    np.testing.assert_array_equal(found.robots["alternation"], 1.0)
    step = config(*WHOLE).control[controller].step
    np.testing.assert_allclose(found.robots["touchdown_rate"], 1 / step.time, atol=0.7)


def test_the_baseline_walks_disturbed_robots(tmp_path):
    """Noise, 5 ms of delay, another robot than the nominal model."""
    overrides = ("evaluation=robust", "evaluation.disturbance.delay={lower: 0.005, upper: 0.005}")
    disturbance = config(*overrides).evaluation.disturbance
    values = baseline(duration=3.0, warm_up=1.4, robots=1, disturbance=disturbance)
    summary = stage.run(values, {}, tmp_path, Job(tmp_path))
    assert summary["success_rate"] == 1.0
    assert summary["mse_steady"] < 0.02
