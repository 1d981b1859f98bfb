"""Good gaits pass; a spoiled gait fails the check of what was spoiled."""

import numpy as np
import pytest

from slider.verification.quantities import QUANTITIES
from slider.verification.stage import check_gait
from tests.verification.sample import failed, gaits, knee_gait, spoiled, table, turning_gait

OWN = ("dynamics", "impact", "mean_velocity", "periodicity", "plant", "plant_impact")


@pytest.mark.parametrize("turns", [False, True])
def test_solved_gaits_pass(turns):
    for gait in [turning_gait()] if turns else gaits():
        assert failed(gait, table()) == set()


def test_gaits_with_the_knees_dynamics_fail_the_checks_of_the_plant_only():
    assert failed(knee_gait(), table("knee"), experiment="paper") == set()
    missed = {"plant_force", "plant_moment", "plant_efforts", "plant_impact"}
    assert missed <= failed(knee_gait(), table("knee"), *OWN)
    missed = {"dynamics_base", "dynamics_torque", "impact_velocity"}
    assert missed <= failed(knee_gait(), table(), *OWN)


def test_checks_give_all_quantities():
    found = check_gait(gaits()[0], table())
    assert set(found) == set(QUANTITIES)
    assert 0.2 < found["plant_cop"] < 0.5


def test_a_value_that_is_no_number_is_the_worst_one():
    nothing = {"roll": lambda _: {"roll_end": np.nan, "dense_leg_distance": np.nan}}
    expected = {"roll_end": np.inf, "dense_leg_distance": -np.inf}
    assert check_gait(gaits()[0], nothing) == expected


@pytest.mark.parametrize(
    ("array", "index", "amount", "caught"),
    [
        ("knee_torques", (5, 2), 1e-3, {"dynamics_torque"}),
        ("efforts", (30, 3), 1e-5, {"dynamics_efforts", "plant_efforts"}),
        ("ground_wrench", (30, 2), 1e-5, {"dynamics_base", "plant_force"}),
        ("ground_wrench", (30, 2), np.nan, {"dynamics_base"}),
        ("ground_wrench", (7, 3), 1e-5, {"dynamics_line_moment", "plant_moment"}),
        ("roll", (0, 9, 2), 1e-5, {"dynamics_base", "plant_force", "plant_efforts"}),
        ("swing_foot", (20, 0), 1e-4, {"mean_velocity"}),
        ("swing_foot", (-1, 0), np.nan, {"mean_velocity"}),
        ("step_time", 1, 1e-4, {"mean_velocity"}),
        ("base", (41, 2), 1e-4, {"periodicity"}),
        ("knee_positions", (21, 4), 1e-4, {"periodicity"}),
        ("knee_velocities", (21, 2), 1e-5, {"impact_velocity", "plant_impact"}),
        ("base", (0, 10), 1e-5, {"impact_velocity", "plant_impact"}),
        ("coefficients", (1, 3, 4), 1e-3, {"dynamics_torque", "plant_efforts"}),
        # of a gait that turns by 0.3 rad/s
        ("velocities", 2, 1e-3, {"impact_velocity", "periodicity"}),
        ("velocities", 0, 0.01, {"mean_velocity"}),
        ("velocities", 2, -0.6, {"impact_velocity", "plant_impact"}),
        ("base", (41, 1), 1e-4, {"periodicity"}),
        ("swing_foot", (41, 1), 1e-4, {"periodicity"}),
    ],
)
def test_spoiled_gaits_are_caught(array, index, amount, caught):
    turning = array == "velocities" or index == (41, 1)
    gait = turning_gait() if turning else gaits()[1]
    found = failed(spoiled(gait, array, index, amount), table(), *OWN)
    assert caught == found if array == "knee_torques" else caught <= found


def test_an_unphysical_roll_is_caught_by_the_other_integrator():
    gait = gaits()[1]
    bent = spoiled(gait, "roll", np.s_[0, :, 0], 0.02 * np.linspace(0.0, 1.0, gait.half))
    assert {"roll_end", "roll_worst"} <= failed(bent, table(), "roll")
