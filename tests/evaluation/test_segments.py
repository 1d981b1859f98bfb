"""Time series of velocities, and measures of segments from recordings with known answers."""

from dataclasses import replace

import numpy as np
import pytest

from slider.config.evaluation import CaseConfig, EvaluationConfig, ProfileConfig, Segment
from slider.env.rollout import Recording
from slider.evaluation import segments
from slider.evaluation.results import SEGMENT_COLUMNS
from slider.evaluation.segments import velocities, windows
from tests.env.synthetic import config, make_recording

PERIOD, STEPS, COUNT = 0.02, 150, 4


def case() -> CaseConfig:
    segments = [
        Segment("stand", 0.0, 0.0, 0.0, 0.0),
        Segment("turn", 1.0, 0.4, 0.0, 0.3),
        Segment("side", 2.0, 0.0, -0.1, 0.0),
    ]
    return CaseConfig("tour", segments)


def test_ramps_lead_from_one_command_to_the_next():
    values = velocities(case(), 0.4, 3.0, PERIOD)
    assert values.shape == (150, 3)
    np.testing.assert_allclose(values[50:71, 0], 0.4 * np.arange(21) / 20, atol=1e-12)
    np.testing.assert_allclose(values[110], [0.2, -0.05, 0.15], atol=1e-12)
    np.testing.assert_array_equal(values[71:100], np.tile([0.4, 0.0, 0.3], (29, 1)))
    assert not values[:50].any()


@pytest.mark.parametrize(("time", "step"), [(0.02, 1), (0.025, 1), (0.035, 2), (0.58, 29)])
def test_a_segment_begins_at_the_nearest_control_step(time, step):
    """Command and window alike."""
    stand, go = Segment("stand", 0.0, 0.0, 0.0, 0.0), Segment("go", time, 0.4, 0.0, 0.0)
    short = CaseConfig("short", [stand, go])
    values = velocities(short, 0.0, 1.0, PERIOD)[:, 0]
    np.testing.assert_array_equal(values, np.where(np.arange(50) < step, 0.0, 0.4))
    assert windows(short, 0.0, 1.0, PERIOD) == [slice(0, step), slice(step, 50)]


def protocol() -> EvaluationConfig:
    whole = config("experiment=test").evaluation
    profile = ProfileConfig(0.0, 0.5, 0.8, cases=[case()])
    return replace(whole, profile=profile, duration=3.0, trials=2, robots=2, speeds=[])


def recording() -> Recording:
    """Robot 0 tracks exactly; 1 is 0.1 m/s and 0.1 rad/s off; 2 falls at 1.9 s; 3 stands still."""
    commanded = velocities(case(), 0.0, 3.0, PERIOD)
    command = np.repeat(commanded[:, None], COUNT, axis=1)
    velocity, rate = command[:, :, :2].copy(), command[:, :, 2].copy()
    velocity[:, 1] += 0.1
    rate[:, 1] += 0.1
    velocity[:, 3], rate[:, 3] = 0.0, 0.0
    position = np.cumsum(velocity, axis=0) * PERIOD  # as if it did not turn
    alive = np.ones((STEPS, COUNT), dtype=bool)
    alive[95:, 2] = False
    forces = np.full((STEPS, COUNT, 2), 50.0)
    forces[130:140, 0, 1] = 0.0
    yaw = np.cumsum(rate, axis=0) * PERIOD
    motion = {"velocity": velocity, "yaw": yaw, "position": position}
    return make_recording(command, alive=alive, foot_forces=forces, **motion)


def measured(rollout: Recording) -> dict[str, np.ndarray]:
    """Measures (3, N) of the three segments."""
    found = segments.measure(rollout, protocol(), case())
    return {name: found[name].to_numpy().reshape(3, COUNT) for name in found}


def test_measures_by_hand():
    shaped = measured(recording())
    assert tuple(shaped) == SEGMENT_COLUMNS
    np.testing.assert_array_equal(shaped["trial"][0], [0, 0, 1, 1])
    np.testing.assert_array_equal(shaped["survived"][:, 2], [True, False, False])
    np.testing.assert_allclose(shaped["vx_error"][1], [0.0, 0.1, np.nan, 0.4], atol=1e-12)
    np.testing.assert_allclose(shaped["vx_mse"][1], [0.0, 0.01, np.nan, 0.16], atol=1e-12)
    np.testing.assert_allclose(shaped["vy_error"][2], [0.0, 0.1, np.nan, 0.1], atol=1e-12)
    np.testing.assert_allclose(shaped["yaw_rate"][1], [0.3, 0.4, np.nan, 0.0], atol=1e-12)
    np.testing.assert_allclose(shaped["yaw_rate_error"][1], [0, 0.1, np.nan, 0.3], atol=1e-12)
    # Robot 3 did not turn when commanded to for a second, and stays that far off.
    np.testing.assert_allclose(shaped["heading_error"][2, [0, 3]], [0.0, 0.3], atol=1e-12)
    np.testing.assert_allclose(shaped["displacement"][0], [0, 0.1 * 2**0.5 * 0.48, 0, 0], atol=1e-9)
    np.testing.assert_allclose(shaped["touchdown_rate"][2, [0, 1]], [1 / 0.5, 0.0])


def test_traces_are_smooth_means_of_those_that_are_up():
    traces = segments.traces(recording(), protocol())
    assert traces.shape == (STEPS, 10)
    np.testing.assert_allclose(traces[:, :3], velocities(case(), 0.0, 3.0, PERIOD), atol=1e-7)
    # Half a second into the second segment, far from its ends: 0.4, 0.5, 0.4 and 0 m/s.
    np.testing.assert_allclose(traces[75, 3], np.mean([0.4, 0.5, 0.4, 0.0]), atol=1e-6)
    np.testing.assert_allclose(traces[75, 6], np.std([0.4, 0.5, 0.4, 0.0]), atol=1e-6)
    np.testing.assert_array_equal(traces[[94, 95], 9], [1.0, 0.75])
    after = recording()
    after.velocity[95:, 2] = 99.0  # lying on the ground, or worse
    np.testing.assert_array_equal(segments.traces(after, protocol()), traces)
    none = segments.traces(replace(recording(), alive=np.zeros((STEPS, COUNT), bool)), protocol())
    assert np.isnan(none[:, 3:9]).all()


def test_the_fastest_half_second_is_within_the_segment():
    rollout = recording()
    rollout.velocity[:75, 0] = 9.0  # before the second segment has settled
    rollout.velocity[99, 0] = (5.4, 0.0)  # one step of 25
    fastest = measured(rollout)["fastest"]
    np.testing.assert_allclose(fastest[1], [0.6, np.hypot(0.5, 0.1), np.nan, 0.0], atol=1e-12)
