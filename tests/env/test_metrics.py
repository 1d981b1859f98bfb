"""Metrics of recordings whose answers are known."""

from typing import Any

import numpy as np
import pytest

from slider.env.instruments import Contacts
from slider.env.metrics import QUALITY, TRACKING, Columns, gait_quality, tracking
from slider.env.rollout import Recording
from tests.env.synthetic import make_contacts, make_recording

PERIOD = 0.02
STEPS = 100  # two seconds
TICKS = 4  # simulation steps per control step
LOADED = 50.0


def recording(count: int = 1, **changes: Any) -> Recording:
    """Robots that stand still with both feet loaded, commanded to 0.5 m/s."""
    command = changes.pop("command", np.tile([0.5, 0.0, 0.0], (STEPS, count, 1)))
    return make_recording(command, **changes)


def forward(*speeds: np.ndarray | float) -> np.ndarray:
    velocity = np.full((STEPS, len(speeds), 2), 7.0)  # sideways does not count
    for robot, speed in enumerate(speeds):
        velocity[:, robot, 0] = speed
    return velocity


def touching(*feet: list[tuple[int, int]]) -> Contacts:
    """Of one robot whose left and right foot carry weight in spans of control steps."""
    forces = np.zeros((STEPS * TICKS, 1, 2))
    for foot, spans in enumerate(feet):
        for start, stop in spans:
            forces[start * TICKS : stop * TICKS, 0, foot] = LOADED
    return make_contacts(forces)


def quality(warm_up: float = 0.0, **changes: Any) -> Columns:
    return gait_quality(recording(**changes), warm_up)


def test_squared_errors_with_and_without_the_start():
    """At rest for the first second, then at the command exactly, or 0.1 m/s off."""
    late = np.arange(STEPS) >= 50
    result = tracking(recording(2, velocity=forward(0.5 * late, 0.6 * late)), 1.0, 0.05, 0.1)
    np.testing.assert_allclose(result["squared_error"], [0.125, 0.5 * 0.25 + 0.5 * 0.01])
    np.testing.assert_allclose(result["squared_error_steady"], [0.0, 0.01], atol=1e-15)
    np.testing.assert_allclose(result["mean_velocity"], [0.5, 0.6])
    np.testing.assert_array_equal(result["tracked"], [True, False])


def test_tracked():
    """An error of 0.1 m/s counts below 1 m/s, a tenth of the command above."""
    speeds = np.array([0.2, 0.2, 0.2, 3.0, 3.0, 3.0, -2.0, -2.0])
    velocity = forward(0.299, 0.101, 0.301, 2.71, 2.69, 3.31, -1.81, -1.79)
    command = np.tile(speeds[:, None] * [1.0, 0.0, 0.0], (STEPS, 1, 1))
    found = tracking(recording(8, velocity=velocity, command=command), 0.0, 0.1, 0.1)["tracked"]
    assert found.tolist() == [True, True, False, True, False, False, True, False]


def test_a_fallen_robot_has_no_numbers_and_does_not_track():
    alive = np.arange(STEPS)[:, None] < [STEPS, 90, STEPS - 1]
    robots = recording(3, velocity=forward(0.5, 0.5, 0.5), alive=alive)
    result, quality = tracking(robots, 1.0, 0.1, 0.1), gait_quality(robots, 1.0)
    for flags in (result["survived"], result["tracked"]):
        np.testing.assert_array_equal(flags, [True, False, False])
    for name in (*TRACKING[1:4], *QUALITY):
        assert np.isnan((result | quality)[name]).tolist() == [False, True, True], name


HOPS = [(10, 20), (30, 40), (50, 60)]


@pytest.mark.parametrize(
    ("left", "right", "expected"),
    [
        (  # steps of 20 periods (0.4 s) with 4 of them in double support
            [(0, 24), (40, 64), (80, 100)],
            [(20, 44), (60, 84)],
            {"flight": 0, "double_support": 0.16, "touchdown_rate": 2, "alternation": 1},
        ),
        # Two hops on the left foot after each other, then one on the right; on both; on one.
        (HOPS[:2], HOPS[2:], {"flight": 0.7, "double_support": 0, "alternation": 0.5}),
        (HOPS, HOPS, {"alternation": 0}),
        (HOPS[:2], [], {"alternation": 0}),
        # A bounce is a contact but no touchdown.
        ([(10, 20), (21, 40), (60, 80)], [], {"touchdown_rate": 1, "contact_rate": 1.5}),
        # From left to right 16 periods and from right to left 24, or 20 each.
        ([(10, 20), (50, 60), (90, 95)], [(26, 40), (66, 80)], {"asymmetry": 0.2}),
        ([(10, 20), (50, 60), (90, 95)], [(30, 40), (70, 80)], {"asymmetry": 0}),
    ],
)
def test_contacts_by_hand(left, right, expected):
    found = quality(contacts=touching(left, right))
    for name, value in expected.items():
        assert found[name] == pytest.approx([value], abs=1e-12), name


def test_clearance_is_that_of_unloaded_soles():
    """The left foot is up by 8 cm for 30 % of the time; the right one slides up while loaded."""
    positions = np.zeros((STEPS, 1, 2, 3))
    positions[20:50, 0, 0, 2] = 0.08
    positions[:, 0, 1, 2] = 0.5
    contacts = touching([(0, 20), (50, STEPS)], [(0, STEPS)])
    found = quality(contacts=contacts, foot_positions=positions)
    assert found["clearance"][0] == pytest.approx(0.04)  # mean over feet


def test_slip_is_the_mean_speed_of_loaded_ends():
    """Left: on its toe for half of the time, at 0.1 m/s; right: fast, but in the air."""
    contacts = touching([(0, 50)], [])
    speeds = np.zeros(contacts.loaded.shape)
    speeds[:, :, 0, 1] = 0.1
    speeds[:, :, 0, 0] = 7.0  # the heel swings
    speeds[:, :, 1] = 3.0
    on_toe = contacts.loaded.copy()
    on_toe[..., 0] = False
    for loaded, expected in ((on_toe, 0.1), (contacts.loaded, (0.1 + 7.0) / 2)):
        found = quality(contacts=contacts._replace(loaded=loaded, speeds=speeds))
        assert found["slip"][0] == pytest.approx(expected)


def test_the_speed_at_which_a_foot_lands_is_no_slip():
    """Its sensors are those before the impact."""
    contacts = touching([(20, 40), (60, 80)], [(0, STEPS)])
    contacts.speeds[[20 * TICKS, 60 * TICKS], :, 0] = 2.0
    assert quality(contacts=contacts)["slip"][0] == 0.0
    contacts.speeds[20 * TICKS + 1, :, 0] = 2.0
    assert quality(contacts=contacts)["slip"][0] > 0.0


def test_penetration_is_the_depth_of_feet_that_carry_weight():
    """Left: 2 mm for half of the time, 6 mm for the rest of its stance; right: in the air."""
    contacts = touching([(0, 50)], [])
    contacts.depths[:] = 0.05  # without force it does not count
    contacts.depths[: 25 * TICKS, :, 0], contacts.depths[25 * TICKS : 50 * TICKS, :, 0] = 2e-3, 6e-3
    contacts.depths[0, :, 0] = -1e-3  # above the ground counts as none
    found = quality(contacts=contacts)
    assert found["penetration"][0] == pytest.approx(4e-3, rel=0.01)
    assert found["penetration_max"][0] == pytest.approx(6e-3)


def test_legs_that_come_close_touch_and_cross():
    """Robot 0 walks wide; 1 touches in one simulation step; 2 crosses for a quarter of the time."""
    distance = np.full((STEPS * TICKS, 3), 0.08)
    distance[3, 1] = -1e-4
    distance[:, 2] = 0.02
    positions = np.zeros((STEPS, 3, 2, 3))
    positions[..., 0, 1], positions[..., 1, 1] = 0.1, -0.1
    positions[:25, 2, :, 1] *= -0.2
    yaw = np.full((STEPS, 3), 2.0)
    rotation = np.array([[np.cos(2.0), -np.sin(2.0)], [np.sin(2.0), np.cos(2.0)]])
    positions[..., :2] = positions[..., :2] @ rotation.T  # the robots go where they look
    contacts = make_contacts(np.full((STEPS * TICKS, 3, 2), LOADED), leg_distance=distance)
    found = quality(1.0, count=3, contacts=contacts, foot_positions=positions, yaw=yaw)
    np.testing.assert_allclose(found["leg_distance"], [0.08, -1e-4, 0.02])
    np.testing.assert_allclose(found["legs_touch"], [0.0, 1 / (STEPS * TICKS), 0.0])
    np.testing.assert_allclose(found["legs_cross"], [0.0, 0.0, 0.25])


def test_energy_and_peaks_count_after_the_start():
    given, late = {"power": 30.0, "effort_share": 0.7, "speed_share": 0.2}, np.arange(STEPS) >= 50
    loads = {name: np.where(late, value, 9.0)[:, None] for name, value in given.items()}
    found = quality(1.0, velocity=forward(0.5), **loads)
    names = ("cost_of_transport", "peak_effort", "peak_speed")
    assert [found[name][0] for name in names] == pytest.approx([30.0 / 100.0 / 0.5, 0.7, 0.2])


def test_velocity_variance_is_about_the_mean():
    swing = 0.5 + 0.1 * np.sign(np.sin(np.arange(STEPS) + 0.5))
    found = quality(velocity=forward(swing))
    assert found["velocity_variance"] == pytest.approx([np.var(swing)])
    assert np.isinf(quality()["cost_of_transport"]).all()


def test_heading_is_about_the_commanded_one():
    """Turning with 0.4 rad/s as commanded, 0.1 rad/s too slowly, and without a command."""
    rate = np.array([0.4, 0.3, 0.3])
    yaw = (rate[None] * PERIOD * np.arange(1, STEPS + 1)[:, None] + 3.0 + np.pi) % (2 * np.pi)
    command = np.zeros((STEPS, 3, 3))
    command[:, :2, 2] = 0.4
    found = quality(yaw=yaw - np.pi, command=command)["heading"]
    np.testing.assert_allclose(found, np.array([0.0, 0.1, 0.3]) * (STEPS - 1) * PERIOD, atol=1e-12)


def test_a_changing_command_is_tracked_in_the_mean():
    command = np.zeros((STEPS, 2, 3))
    command[50:, :, 0] = 1.0
    one_stays = recording(2, velocity=command[..., :2] * [[1.0], [0.0]], command=command)
    found = tracking(one_stays, 0.0, 0.01, 0.0)
    assert found["tracked"].tolist() == [True, False]
    np.testing.assert_allclose(found["squared_error"], [0.0, 0.5])
