"""Metrics of recordings whose answers are known."""

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from slider.env.metrics import GaitQuality, Tracking, gait_quality, tracking
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
    velocity = np.zeros((STEPS, len(speeds), 2))
    for robot, speed in enumerate(speeds):
        velocity[:, robot, 0] = speed
    velocity[:, :, 1] = 7.0  # sideways does not count
    return velocity


def contact(*feet: np.ndarray) -> np.ndarray:
    """Forces of one robot from 0/1 patterns of the left and the right foot."""
    return LOADED * np.stack(feet, axis=1)[:, None, :].astype(float)


def pattern(*spans: tuple[int, int]) -> np.ndarray:
    loaded = np.zeros(STEPS)
    for start, stop in spans:
        loaded[start:stop] = 1
    return loaded


def test_squared_errors_with_and_without_the_start():
    """At rest for the first second, then at the command exactly, or 0.1 m/s off."""
    late = np.arange(STEPS) >= 50
    result = tracking(recording(2, velocity=forward(0.5 * late, 0.6 * late)), 1.0, 0.05, 0.1)
    np.testing.assert_allclose(result.squared_error, [0.125, 0.5 * 0.25 + 0.5 * 0.01])
    np.testing.assert_allclose(result.squared_error_steady, [0.0, 0.01], atol=1e-15)
    np.testing.assert_allclose(result.mean_velocity, [0.5, 0.6])
    np.testing.assert_array_equal(result.tracked, [True, False])


@pytest.mark.parametrize(
    ("command", "mean", "tracked"),
    [
        (0.2, 0.299, True),  # 0.1 m/s counts below 1 m/s
        (0.2, 0.101, True),
        (0.2, 0.301, False),
        (3.0, 2.71, True),  # a tenth counts above
        (3.0, 2.69, False),
        (3.0, 3.31, False),
        (-2.0, -1.81, True),
        (-2.0, -1.79, False),
    ],
)
def test_tracked(command, mean, tracked):
    one = recording(1, velocity=forward(mean), command=np.full((STEPS, 1, 3), [command, 0, 0]))
    assert tracking(one, 0.0, 0.1, 0.1).tracked[0] == tracked


def test_a_fallen_robot_has_no_numbers_and_does_not_track():
    alive = np.ones((STEPS, 3), dtype=bool)
    alive[90:, 1] = False
    alive[-1, 2] = False
    robots = recording(3, velocity=forward(0.5, 0.5, 0.5), alive=alive)
    result, quality = tracking(robots, 1.0, 0.1, 0.1), gait_quality(robots, 1.0)
    np.testing.assert_array_equal(result.survived, [True, False, False])
    np.testing.assert_array_equal(result.tracked, [True, False, False])
    for item in fields(Tracking)[1:4]:
        assert np.isnan(getattr(result, item.name)).tolist() == [False, True, True], item.name
    for item in fields(GaitQuality):
        assert np.isnan(getattr(quality, item.name)).tolist() == [False, True, True], item.name


def test_walking_left_and_right():
    """Steps of 20 periods (0.4 s) with 4 of them in double support."""
    left = pattern((0, 24), (40, 64), (80, 100))
    right = pattern((20, 44), (60, 84))
    quality = gait_quality(recording(1, foot_forces=contact(left, right)), 0.0)
    assert quality.flight[0] == 0.0
    assert quality.double_support[0] == pytest.approx(16 / 100)
    assert quality.touchdown_rate[0] == pytest.approx(4 / 2.0)
    assert quality.alternation[0] == 1.0


def test_hopping_and_limping():
    """Two hops on the left foot after each other, then one on the right."""
    left = pattern((10, 20), (30, 40))
    right = pattern((50, 60))
    quality = gait_quality(recording(1, foot_forces=contact(left, right)), 0.0)
    assert quality.flight[0] == pytest.approx(70 / 100)
    assert quality.double_support[0] == 0.0
    assert quality.alternation[0] == pytest.approx(0.5)
    both = contact(pattern((10, 20), (30, 40), (50, 60)), pattern((10, 20), (30, 40), (50, 60)))
    assert gait_quality(recording(1, foot_forces=both), 0.0).alternation[0] == 0.0
    only_left = gait_quality(recording(1, foot_forces=contact(left, 0 * left)), 0.0)
    assert only_left.alternation[0] == 0.0


def test_bounces_are_contacts_but_no_touchdowns():
    bouncing, lifted = pattern((10, 20), (21, 40), (60, 80)), pattern((0, 0))
    quality = gait_quality(recording(1, foot_forces=contact(bouncing, lifted)), 0.0)
    assert quality.touchdown_rate[0] == pytest.approx(2 / 2.0)
    assert quality.contact_rate[0] == pytest.approx(3 / 2.0)


def test_clearance_is_that_of_unloaded_soles():
    """The left foot is up by 8 cm for 30 % of the time; the right one slides up while loaded."""
    left = 1 - pattern((20, 50))
    positions = np.zeros((STEPS, 1, 2, 3))
    positions[20:50, 0, 0, 2] = 0.08
    positions[:, 0, 1, 2] = 0.5
    one = recording(1, foot_forces=contact(left, np.ones(STEPS)), foot_positions=positions)
    assert gait_quality(one, 0.0).clearance[0] == pytest.approx(0.04)  # mean over feet


def test_slip_is_the_mean_speed_of_loaded_ends():
    """Left: on its toe for half of the time, at 0.1 m/s; right: fast, but in the air."""
    forces = contact(pattern((0, 50)), np.zeros(STEPS))
    contacts = make_contacts(np.repeat(forces, TICKS, axis=0))
    speeds = np.zeros(contacts.loaded.shape)
    speeds[:, :, 0, 1] = 0.1
    speeds[:, :, 0, 0] = 7.0  # the heel swings
    speeds[:, :, 1] = 3.0
    on_toe = contacts.loaded.copy()
    on_toe[..., 0] = False
    one = recording(contacts=contacts._replace(loaded=on_toe, speeds=speeds))
    assert gait_quality(one, 0.0).slip[0] == pytest.approx(0.1)
    flat = recording(contacts=contacts._replace(speeds=speeds))
    assert gait_quality(flat, 0.0).slip[0] == pytest.approx((0.1 + 7.0) / 2)


def test_the_speed_at_which_a_foot_lands_is_no_slip():
    """Its sensors are those before the impact."""
    forces = contact(pattern((20, 40), (60, 80)), np.ones(STEPS))
    contacts = make_contacts(np.repeat(forces, TICKS, axis=0))
    contacts.speeds[[20 * TICKS, 60 * TICKS], :, 0] = 2.0
    assert gait_quality(recording(contacts=contacts), 0.0).slip[0] == 0.0
    contacts.speeds[20 * TICKS + 1, :, 0] = 2.0
    assert gait_quality(recording(contacts=contacts), 0.0).slip[0] > 0.0


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
    robots = recording(3, contacts=contacts, foot_positions=positions, yaw=yaw)
    found = gait_quality(robots, 1.0)
    np.testing.assert_allclose(found.leg_distance, [0.08, -1e-4, 0.02])
    np.testing.assert_allclose(found.legs_touch, [0.0, 1 / (STEPS * TICKS), 0.0])
    np.testing.assert_allclose(found.legs_cross, [0.0, 0.0, 0.25])


def test_asymmetry_of_step_times():
    """Left lands at 10, 50, 90; right at 26, 66 (16 and 24 steps apart) or evenly at 30, 70."""
    left = pattern((10, 20), (50, 60), (90, 95))
    limping, even = pattern((26, 40), (66, 80)), pattern((30, 40), (70, 80))
    found = [gait_quality(recording(foot_forces=contact(left, r)), 0.0) for r in (limping, even)]
    assert found[0].asymmetry == pytest.approx([(24 - 16) / 40])
    assert found[1].asymmetry == pytest.approx([0.0])


def test_energy_and_peaks_count_after_the_start():
    late = np.arange(STEPS)[:, None] >= 50
    start = np.where(late, 0.0, 9.0)
    found = gait_quality(
        recording(
            velocity=forward(0.5),
            power=30.0 * late + start,
            effort_share=0.7 * late + start,
            speed_share=0.2 * late + start,
        ),
        1.0,
    )
    assert found.cost_of_transport == pytest.approx([30.0 / 100.0 / 0.5])
    assert found.peak_effort == pytest.approx([0.7])
    assert found.peak_speed == pytest.approx([0.2])


def test_velocity_variance_is_about_the_mean():
    swing = 0.5 + 0.1 * np.sign(np.sin(np.arange(STEPS) + 0.5))
    found = gait_quality(recording(velocity=forward(swing)), 0.0)
    assert found.velocity_variance == pytest.approx([np.var(swing)])
    assert np.isinf(gait_quality(recording(), 0.0).cost_of_transport).all()


def test_heading_is_about_the_commanded_one():
    """Turning with 0.4 rad/s as commanded, 0.1 rad/s too slowly, and without a command."""
    rate = np.array([0.4, 0.3, 0.3])
    yaw = (rate[None] * PERIOD * np.arange(1, STEPS + 1)[:, None] + 3.0 + np.pi) % (2 * np.pi)
    command = np.zeros((STEPS, 3, 3))
    command[:, :2, 2] = 0.4
    turning = recording(3, yaw=yaw - np.pi, command=command)
    span = (STEPS - 1) * PERIOD
    np.testing.assert_allclose(
        gait_quality(turning, 0.0).heading, [0.0, 0.1 * span, 0.3 * span], atol=1e-12
    )


def test_a_changing_command_is_tracked_in_the_mean():
    command = np.zeros((STEPS, 1, 3))
    command[50:, :, 0] = 1.0
    follows = tracking(recording(1, velocity=command[:, :, :2], command=command), 0.0, 0.01, 0.0)
    assert follows.tracked.all()
    assert follows.squared_error[0] == 0.0
    stays = tracking(recording(1, command=command), 0.0, 0.01, 0.0)
    assert not stays.tracked.any()
    np.testing.assert_allclose(stays.squared_error, 0.5)
