"""Every reward term by hand, the printed reward by its formula, the guide by brute force."""

from dataclasses import fields

import numpy as np
import pytest
import torch
from scipy.linalg import solve_continuous_are

from slider.config.train import RewardConfig, RewardTerm
from slider.env.guide import observed_channels
from slider.env.rewards import TERMS, Lyapunov, Reward, RewardView
from slider.env.state import RobotState, View
from tests.env.synthetic import (
    CHANNELS,
    JOINTS,
    MOTORS,
    TURNING,
    config,
    gait_table,
    library,
    make_guide,
    make_state,
    make_view,
    random_view,
)

HEIGHT = 0.685
STAND = [0.0, 0.0, 0.0, 0.3]  # a heading error is no command


def value(name: str, view: View, gait: str = "interpolated", **params: float) -> np.ndarray:
    return TERMS[name].function(RewardView(view, make_guide(gait)), **params)


def joint(name: str, number: float) -> np.ndarray:
    return number * (np.array(JOINTS) == name)


def motor(name: str, number: float) -> np.ndarray:
    return number * (np.array(MOTORS) == name)


HAND = {  # term → (quantities of state and view, parameters, value)
    "alive": ({}, {}, 1.0),
    "stand_still": (
        {"foot_forces": [100.0, 0.0], "joint_velocities": np.eye(1, 12) / 2, "command": [STAND]},
        {"loaded": 20.0, "width": 2.0},
        0.5 * np.exp(-0.25 / 2.0),
    ),
    "forward_velocity": (
        {"heading_velocity": [0.5, 3.0], "reference_velocity": [[0.2, 0.0]]},
        {},
        1 - np.tanh(0.3),
    ),
    "forward_velocity_filtered": (
        {"filtered_velocity": [[1.7, 9.0]], "expected_velocity": [[2.0, 3.0]]},
        {"width": 0.01, "relative": 0.02},
        np.exp(-(0.3**2) / (0.01 + 0.02 * 4.0)),
    ),
    "lateral_velocity_filtered": (
        {"filtered_velocity": [[9.0, -0.1]], "expected_velocity": [[2.0, 0.1]]},
        {"width": 0.05},
        1 - np.tanh(0.2 / 0.05),
    ),
    "yaw_rate": (
        {"angular_velocity": [3.0, 3.0, 0.4], "command": [[0, 0, 0.1, 0]]},
        {"width": 0.5},
        np.exp(-0.09 / 0.5),
    ),
    "heading": ({"command": [[0, 0, 0, -0.2]]}, {"width": 0.1}, np.exp(-0.4)),
    "upright": ({"gravity": [0.3, -0.4, -0.866]}, {"width": 0.5}, np.exp(-0.5)),
    "height": ({"base_position": [5.0, 5.0, HEIGHT - 0.1]}, {"width": 0.02}, np.exp(-0.5)),
    # The synthetic gaits keep the nominal height.
    "guide_height": ({"base_position": [5.0, 5.0, HEIGHT + 0.1]}, {"width": 0.02}, np.exp(-0.5)),
    "action_rate": ({"action": [[0.5] * 12], "previous_action": [[0.2] * 12]}, {}, 12 * 0.09),
    "roll_pitch_rate": ({"angular_velocity": [0.3, -0.4, 7.0]}, {}, 0.25),
    "effort": (  # half of a capstan motor's limit, a quarter of a hip's
        {"motor_torques": motor("left_leg_1", 4.5) + motor("right_hip_roll", -15.0)},
        {},
        0.25 + 0.0625,
    ),
    "foot_slip": (  # the right foot is not loaded, vertical speed is no slip
        {"foot_velocities": [[0.3, -0.4, 2.0], [5.0, 5.0, 5.0]], "foot_forces": [50.0, 4.0]},
        {"loaded": 5.0, "width": 0.5},
        1 - np.exp(-0.25 / 0.5),
    ),
    "soft_landing": (  # the right foot comes down more slowly than is asked for
        {
            "foot_velocities": [[3.0, 0.0, -1.0], [0.0, 0.0, -0.3]],
            "foot_positions": [[0.0, 0.1, 0.03], [0.0, -0.1, 0.03]],
        },
        {"speed": 0.4, "height": 0.06},
        0.6 * np.exp(-0.5),
    ),
    "airborne": ({"foot_forces": [0.9, 0.2]}, {"unloaded": 1.0}, 1.0),
    "feet_close": (  # a robot that looks along y: left is −x
        {"foot_positions": [[-0.02, 0.3, 0.0], [0.01, 0.0, 0.0]], "yaw": np.pi / 2},
        {"least": 0.12},
        1 - 0.03 / 0.12,
    ),
}
BELOW = {"guide_phase", "guide_phase_turning", "guide_nearest", "contact_schedule", "clf_value"}
BELOW |= {"clf_decrease", *config("experiment=paper").train.walking.reward.terms}


@pytest.mark.parametrize("name", [*HAND, *sorted(TERMS.keys() - HAND.keys() - BELOW)])
def test_by_hand(name):
    if name not in HAND:
        pytest.skip(f"HAND has no case of {name}")
    given, params, expected = HAND[name]
    state = {item.name: given[item.name] for item in fields(RobotState) if item.name in given}
    view = {name: values for name, values in given.items() if name not in state}
    found = value(name, make_view(make_state(1, **state), **view), **params)
    assert found.shape == (1,)
    assert found[0] == pytest.approx(expected, rel=1e-9)


COSTS = {"action_rate", "roll_pitch_rate", "effort", "foot_slip", "soft_landing", "airborne"}
COSTS |= {"feet_close"}


@pytest.mark.parametrize("training", ["standing", "walking"])
def test_default_weights_have_the_sign_of_their_term_and_a_fall_never_pays(training):
    reward = getattr(config().train, training).reward
    known = {*reward.active} & {*HAND, *BELOW}
    assert {name for name in known if reward.terms[name].weight < 0} == known & COSTS
    assert reward.on_fall < 0.0 <= reward.floor


def test_standing_still_counts_only_at_zero_command():
    loaded = make_state(3, foot_forces=100.0)
    view = make_view(loaded, command=[STAND, [0.1, 0, 0, 0], [0, 0, -0.1, 0]])
    np.testing.assert_array_equal(value("stand_still", view, loaded=20.0, width=2.0), [1, 0, 0])


def test_a_commanded_turn_moves_the_hip_yaws_of_the_guide():
    """Over a stance foot that stays, the base turns by ψ̇ T in a step; legs swap at its end."""
    rate, table = 0.3, gait_table()
    command = np.tile([0.4, 0.0, rate, 0.0], (4, 1))
    phase = np.array([0.0, 0.4999999, 0.5, 0.9999999])
    view = make_view(make_state(4), command=command, phase=phase)
    half = 0.5 * rate * table.times.at(command[:, :3])[0]
    yaws = [JOINTS.index("left_hip_yaw"), JOINTS.index("right_hip_yaw")]
    turn = make_guide().turn(view).numpy()
    np.testing.assert_allclose(
        turn[:, yaws], half * np.array([[1, -1], [-1, 1], [-1, 1], [1, -1]]), atol=1e-6
    )
    assert not np.delete(turn, yaws, axis=1).any()
    reference = table.at(command[:, :3], phase)[:, :12]
    on_it = make_view(make_state(4, joint_positions=reference + turn), command=command, phase=phase)
    np.testing.assert_allclose(value("guide_phase_turning", on_it, width=0.35), 1.0)
    assert (value("guide_phase", on_it, width=0.35) < 1.0).all()
    straight = random_view(40)
    straight.command[:, 2] = 0.0
    np.testing.assert_array_equal(
        value("guide_phase_turning", straight, width=0.35),
        value("guide_phase", straight, width=0.35),
    )


def test_contact_schedule():
    """Left stance as asked, the wrong foot, none; right stance; near a switch nothing is asked."""
    forces = 100.0 * np.array([[1, 0], [0, 1], [0, 0], [0, 1], [0, 1], [0, 0]])
    view = make_view(make_state(6, foot_forces=forces), phase=[0.25, 0.25, 0.25, 0.75, 0.02, 0.48])
    found = value("contact_schedule", view, loaded=20.0, unloaded=1.0, margin=0.15)
    np.testing.assert_allclose(found, [1.0, 0.0, 0.5, 1.0, 1.0, 1.0])


def test_the_guide_of_a_halted_robot_is_standing():
    command = np.zeros((2, 4))
    view = make_view(make_state(2), phase=[0.5, 0.5], command=command, halted=[True, False])
    stands, steps = make_guide().at_phase(view)
    np.testing.assert_array_equal(stands, gait_table().standing)
    np.testing.assert_array_equal(steps, gait_table().at(np.zeros((1, 3)), np.array([0.5]))[0])
    assert (stands != steps).any()


def test_guide_phase_is_one_on_the_gait_and_counts_a_metre_of_slide_more():
    view = random_view(40)
    reference = gait_table().at(view.command[:, :3].numpy(), view.phase.numpy())[:, :12]

    def off(name: str, error: float) -> np.ndarray:
        state = make_state(40, joint_positions=reference + joint(name, error))
        placed = make_view(state, command=view.command, phase=view.phase)
        return value("guide_phase", placed, width=0.35)

    np.testing.assert_allclose(off("left_slide", 0.0), 1.0)
    np.testing.assert_allclose(off("right_upper_foot", 0.5), 1.0)
    hip, slide = off("right_hip_pitch", 0.1), off("left_slide", 0.1)
    assert (hip < 1.0).all()
    assert (slide < hip).all()
    np.testing.assert_allclose(hip, hip[0])
    np.testing.assert_allclose(off("left_hip_pitch", 0.1), hip)


CLF = {"bandwidth": 20.0, "rate_weight": 2.0, "eta_max": 0.5}  # P = [[2, 1], [1, 2]]
RATES = {"eta_dot_max": 5.0, "decay": 4.0}
SCALE = 2 * 3.0 * 0.5 * 5.0 + 4.0 * 3.0 * 0.5**2  # 2‖P‖ η_max η̇_max + decay λ_max(P) η_max²


def off_the_gait(name: str, error: float, rate: float = 0.0) -> View:
    """A robot whose joint is off by [rad or m], with a rate that is off as well."""
    phase, command = np.array([0.3]), np.array([[0.4, 0.0, 0.0, 0.0]])
    gait = gait_table().at(command[:, :3], phase)
    positions, rates = gait[:, :12] + joint(name, error), gait[:, 12:24] + joint(name, rate)
    state = make_state(1, joint_positions=positions, joint_velocities=rates)
    return make_view(state, command=command, phase=phase)


@pytest.mark.parametrize(
    ("name", "error", "rate", "lyapunov"),
    [
        ("left_hip_pitch", 0.0, 0.0, 0.0),
        ("left_hip_pitch", 0.2, 0.0, 2 * 0.04),
        ("right_ankle", 0.0, 4.0, 0.5 * 2 * 0.2**2),
        ("right_slide", 0.05, -2.0, 40 * (2 * 0.05**2 - 2 * 0.05 * 0.1 + 2 * 0.1**2)),
        ("left_upper_foot", 9.0, 9.0, 0.0),  # no motor, no output
    ],
)
def test_clf_value(name, error, rate, lyapunov):
    found = value("clf_value", off_the_gait(name, error, rate), **CLF)
    np.testing.assert_allclose(found, [np.exp(-lyapunov / (3.0 * 0.5**2))], rtol=1e-9)


@pytest.mark.parametrize(
    ("before", "now", "expected"),
    [
        (0.2, 0.1, 0.0),  # falls faster than asked
        (0.1, 0.1, 4.0 * 0.02 / SCALE),  # stays: V = 0.02
        (0.1, 0.1 * np.exp(-0.5 * 4.0 * 0.02), 0.0),  # falls as e^(−decay t), in one step
        (0.1, 0.11, ((0.0242 - 0.02) / 0.02 + 4.0 * 0.0242) / SCALE),
        (0.0, 5.0, 1.0),
        (0.0, 0.0, 0.0),
    ],
)
def test_clf_decrease(before, now, expected):
    guide = make_guide()
    last, view = (off_the_gait("left_hip_pitch", error) for error in (before, now))
    seen = RewardView(view, guide, RewardView(last, guide).outputs)
    found = TERMS["clf_decrease"].function(seen, **CLF, **RATES)
    np.testing.assert_allclose(found, [expected], rtol=1e-9, atol=2e-4 if before > now else 1e-12)
    start = RewardView(view, guide, torch.full_like(seen.outputs, np.inf))
    first = TERMS["clf_decrease"].function(start, **CLF, **RATES)
    np.testing.assert_array_equal(first, [0.0], "V is infinite before an episode")


def brute_force(view: View, keep: np.ndarray, gait: str = "nearest") -> np.ndarray:
    """Distance to the nearest of the 42 samples of a gait, one robot at a time.

    Half way between two gaits the samples of the interpolated one are their means.
    """
    gaits, observed = library(), observed_channels(view).numpy()
    samples, result = gaits.arrays["samples"], []
    for command, seen in zip(view.command.numpy(), observed, strict=True):
        distance = [np.hypot(*(v - command[:2])) for v in gaits.velocities[:, :2]]
        near = np.argsort(distance)[: 1 if gait == "nearest" else 2]
        errors = [np.linalg.norm((seen - s)[keep]) for s in samples[near].mean(axis=0)]
        assert len(errors) == 42
        result.append(min(errors))
    return np.array(result)


def test_gaits_that_turn_need_the_hip_yaws_of_what_they_lack_only():
    """In the middle of the grid nothing; beyond its border what is missing there."""
    guide, flat = make_guide("interpolated", *TURNING), make_guide()
    command = np.tile([0.2, 0.05, 0.0, 0.0], (4, 1))
    command[:, 2] = [0.2, -0.3, 0.5, 0.0]
    phase = np.array([0.1, 0.3, 0.6, 0.9])
    view = make_view(make_state(4), command=command, phase=phase)
    missing = make_view(make_state(4), command=command * [1, 1, 0, 0], phase=phase)
    missing.command[2, 2] = 0.2
    np.testing.assert_allclose(guide.turn(view), flat.turn(missing), atol=1e-12)
    turned = guide.at_phase(view)[:, :12] + guide.turn(view)
    expected = flat.at_phase(view)[:, :12] + flat.turn(view)  # synthetic gaits turn by their hips
    np.testing.assert_allclose(turned, expected, atol=1e-12)


@pytest.mark.parametrize("gait", ["nearest", "interpolated"])
@pytest.mark.parametrize("masked", [0.0, 1.0])
def test_guide_nearest_against_brute_force(masked, gait):
    view = random_view(40)
    if gait == "interpolated":
        view.command[:, :2] = torch.tensor([0.2, 0.0])  # half way between two gaits
    keep = np.array([not (masked and "upper_foot" in name) for name in CHANNELS])
    assert keep.sum() == (22 if masked else 26)
    found = value("guide_nearest", view, gait, masked=masked)
    np.testing.assert_allclose(found, -brute_force(view, keep, gait), rtol=1e-5, atol=1e-5)


def test_the_printed_reward():
    """The terms as printed, with their weights, computed here from the state alone."""
    view = random_view(40)
    train = config("experiment=paper").train.walking
    guided = RewardView(view, make_guide(train.guide.gait))
    reward, parts = Reward(train.reward)(guided, np.zeros(40, dtype=bool))
    state, zero = view.state, torch.zeros(40, dtype=torch.float64)
    v_des = torch.stack([view.command[:, 0], view.command[:, 1], zero], dim=1)
    w_des = torch.stack([zero, zero, view.command[:, 2]], dim=1)

    def tanh(values: torch.Tensor) -> np.ndarray:
        return np.tanh(values.norm(dim=1).numpy())

    expected = {
        "guide_nearest": -brute_force(view, np.ones(26, dtype=bool)),
        "torque_tanh": -0.5 * tanh(state.motor_torques),
        "angular_velocity_tanh": -3.0 * tanh(state.angular_velocity),
        "linear_error_tanh": -1.0 * tanh(state.linear_velocity - v_des),
        "angular_error_tanh": -1.0 * tanh(state.angular_velocity - w_des),
        "height_tanh": 2.0 * np.tanh(state.base_position[:, 2].numpy()),
        # Position commands.
        "action_rate_tanh": -1.0 * tanh(0.3 * (view.action - view.previous_action)),
    }
    assert parts.keys() == expected.keys()
    for name, values in expected.items():
        np.testing.assert_allclose(parts[name], values, rtol=1e-5, atol=1e-5, err_msg=name)
    np.testing.assert_allclose(reward, sum(expected.values()), rtol=1e-5, atol=1e-4)


RAW = 2.0 - 10.0 * np.tanh([0.1, 0.6])  # one above zero, one below


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({}, RAW),
        ({"floor": 0.0}, [RAW[0], 0.0]),
        ({"scale": 0.5}, 0.5 * RAW),
        ({"floor": 0.0, "scale": 0.5, "on_fall": -3.0}, [0.5 * RAW[0], -3.0]),
    ],
)
def test_floor_then_scale_then_fall(settings, expected):
    terms = {"alive": RewardTerm(2.0), "height_tanh": RewardTerm(-10.0)}
    config = RewardConfig(terms, **{"scale": 1.0, "floor": -1e9, "on_fall": 0.0} | settings)
    view = RewardView(make_view(make_state(2, base_position=[[0, 0, 0.1], [0, 0, 0.6]])), None)
    total, parts = Reward(config)(view, np.array([False, True]))
    np.testing.assert_allclose(total, expected)
    np.testing.assert_allclose(sum(parts.values()), RAW)


@pytest.mark.parametrize("case", [(20.0, 2.0), (1.0, 0.0), (7.3, 11.0)])
def test_p_solves_the_riccati_equation(case):
    """Q and R in seconds: V is ω times the cost of their LQR."""
    clf = Lyapunov(*case)
    q, r = np.diag([1.0, clf.rate_weight / clf.bandwidth**2]), [[clf.bandwidth**-4.0]]
    solution = solve_continuous_are(np.eye(2, k=1), [[0.0], [1.0]], q, r)
    error = np.random.default_rng(0).standard_normal((5, 2, 3))
    expected = clf.bandwidth * np.einsum("nik,ij,njk->n", error, solution, error)
    np.testing.assert_allclose(clf.value(error), expected, rtol=1e-9)
