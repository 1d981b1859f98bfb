"""Gaits of a robot with soles: good ones pass, and what was spoiled is found."""

from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

from pipeline.stages.gaits import gait_section
from slider.config.convert import to_dict
from slider.config.robot import Mechanism
from slider.core.job import Job
from slider.gait import stage as gait_stage
from slider.robot import names
from slider.verification.pin_robot import PinRobot
from slider.verification.plant import Plant, plant_state
from slider.verification.quantities import QUANTITIES
from slider.verification.stage import check_gait, checks
from slider.verification.stored import StoredGait
from tests import shared
from tests.robot.soled import soled
from tests.verification.sample import config, spoiled

TURNING = (0.4, -0.05, 0.2)
STRAIGHT = (0.3, 0.0, 0.0)
QUICK = ("dynamics", "impact", "periodicity", "plant", "plant_impact")


@shared.shared
def solved(velocity: tuple[float, float, float]) -> Path:
    out = Path(mkdtemp(prefix="soled-", dir=shared.folder()))
    robot = {f.name: to_dict(soled())[f.name] for f in fields(Mechanism)}
    section = gait_section(config()) | {"robot": robot, "velocity": [*velocity]}
    assert gait_stage.run(section, {}, out, Job(out))["converged"]
    return out


@cache
def gait(velocity: tuple[float, float, float] = STRAIGHT) -> StoredGait:
    stored = [f.name for f in fields(StoredGait) if f.name not in ("geometry", "velocities")]
    arrays = {name: np.load(solved(velocity) / f"{name}.npy") for name in stored}
    return StoredGait(soled().geometry, np.array(velocity), **arrays)


def failed(walk: StoredGait, *some: str, robot=None) -> set[str]:
    """Quantities beyond the configured bounds, of some checks or all."""
    settings = config().verification
    table = checks(robot or soled(), config().gait.posture, "prismatic", settings)
    values = check_gait(walk, {name: table[name] for name in some or table})
    assert some or set(values) == set(QUANTITIES)
    signs = {name: -1 if QUANTITIES[name].at_least else 1 for name in values}
    return {n for n, x in values.items() if signs[n] * x > signs[n] * settings.bounds[n]}


@pytest.mark.parametrize("velocity", [STRAIGHT, TURNING])
def test_solved_gaits_pass(velocity):
    assert failed(gait(velocity)) == set()


@pytest.mark.parametrize(
    ("array", "index", "amount", "caught"),
    [
        ("samples", (5, 11), 1e-3, {"dynamics_base", "dynamics_efforts", "plant_efforts"}),
        ("samples", (30, 11), 1e-3, {"dynamics_base", "plant_moment"}),  # stance
        ("samples", (20, 17), 1e-3, {"impact_velocity", "plant_impact"}),
        ("samples", (21, 5), 1e-3, {"periodicity"}),
        ("efforts", (5, 11), 1e-5, {"dynamics_efforts", "plant_efforts"}),
        ("efforts", (5, 5), 1e-5, {"dynamics_line_moment", "dynamics_efforts"}),
        ("ground_wrench", (7, 3), 1e-5, {"dynamics_base", "plant_moment"}),
        ("roll", (0, 9, 2), 1e-3, {"dynamics_efforts", "dynamics_line_moment"}),
    ],
)
def test_spoiled_gaits_are_caught(array, index, amount, caught):
    assert caught <= failed(spoiled(gait(), array, index, amount), *QUICK)


def test_a_swing_ankle_that_rolls_the_other_way_is_caught():
    walk = gait()
    mirrored = spoiled(walk, "samples", np.s_[:21, 11], -2 * walk.samples[:21, 11])
    assert {"dynamics_base", "dynamics_efforts", "plant_force"} <= failed(mirrored, *QUICK)


def test_an_unphysical_roll_is_caught_by_the_other_integrator():
    walk = gait()
    bent = spoiled(walk, "roll", np.s_[0, :, 0], 0.02 * np.linspace(0.0, 1.0, walk.half))
    assert {"roll_end", "roll_worst"} <= failed(bent, "roll")


def test_another_talus_is_caught():
    talus = replace(soled().links.talus, mass=1.1 * soled().links.talus.mass)
    other = replace(soled(), links=replace(soled().links, talus=talus))
    missed = {"dynamics_base", "dynamics_efforts", "plant_force", "impact_velocity"}
    assert missed <= failed(gait(), *QUICK, robot=other)


def test_a_narrow_sole_tips():
    narrow = replace(soled().geometry.sole, width=0.01)
    other = replace(soled(), geometry=replace(soled().geometry, sole=narrow))
    assert failed(gait(), "plant", "dense", robot=other) == {"plant_cop", "dense_cop"}


def test_pinocchio_and_mujoco_agree_on_random_motions_and_impacts():
    rng, robot, plant = np.random.default_rng(0), PinRobot(soled(), "prismatic"), Plant(soled())
    for side in names.SIDES * 5:
        motion = rng.normal(size=(3, 10)) * [[0.2], [2.0], [20.0]]
        state = robot.standing(rng.normal(size=3) * [0.1, 1.0, 5.0], *motion, side)
        efforts, wrench = robot.inverse_dynamics(state, side)
        forces, jacobian = plant.inverse(plant_state(state), side)
        rest = forces - jacobian.T @ wrench
        np.testing.assert_allclose(rest, [*[0.0] * 6, *efforts], atol=1e-6)
        landing = names.other_side(side)
        after, other = (
            robot.impact(state.q, state.v, landing),
            plant.impact(plant_state(state), landing),
        )
        np.testing.assert_allclose(other[6:], after[6:], atol=1e-8)
        np.testing.assert_allclose(robot.jacobian(state.q, landing) @ after, 0.0, atol=1e-9)


def test_soles_are_level_along_a_motion():
    """Angle, rate and acceleration of the swing ankle's roll against finite differences."""
    robot, motion, step = PinRobot(soled(), "prismatic"), gait().steps[1], 1e-5
    before, now, after = (robot.moving(motion, 0.2 + way) for way in (-step, 0.0, step))
    np.testing.assert_allclose(now.v[6:], (after.q - before.q)[7:] / (2 * step), atol=1e-6)
    np.testing.assert_allclose(now.a[6:], (after.v - before.v)[6:] / (2 * step), atol=1e-5)
    standing = robot.jacobian(now.q, motion.side)
    tilt = robot.data.oMf[robot.sole("left")].rotation[2, 1]
    assert tilt == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(standing @ now.v, 0.0, atol=1e-12)
