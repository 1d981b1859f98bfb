"""CasADi's robot against MuJoCo's, axes apart and bodies off the leg's axis, and pinocchio's."""

from dataclasses import replace
from functools import cache

import casadi as ca
import mujoco
import numpy as np
import pytest

from slider.gait.formulation import Formulation
from slider.gait.rooted import NUM, RootedRobot
from slider.gait.transcription import NODE
from slider.robot.knee_map import reflected
from slider.robot.names import GRAVITY, SIDES
from slider.verification.pin_robot import PinRobot
from slider.verification.plant import Plant, PlantState, plant_state
from tests.gait.gaits import config, inverse_dynamics
from tests.robot.lopsided import lopsided, turned

POLAR, AXIAL = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])


ROBOTS = {"lopsided": lopsided(), "turned": turned(False), "turned and kneed": turned(True)}


@cache
def plant(robot: str) -> Plant:
    return Plant(ROBOTS[robot])


def standing(
    robot: str, side: str, roll: np.ndarray, q: np.ndarray, *motion: np.ndarray
) -> PlantState:
    """MuJoCo's state of roll (3,) and own joints (10,), stance leg first, reflected."""
    if side == "right":
        geometry = ROBOTS[robot].geometry
        roll, q, *motion = -roll, *(reflected(values, geometry) for values in (q, *motion))
    return plant_state(plant(robot).slides.standing(roll, q, *motion, side))


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("side", SIDES)
def test_efforts_and_wrench(side, robot):
    form = Formulation(ROBOTS[robot], config().gait)
    rng, rooted, geometry = np.random.default_rng(0), inverse_dynamics(form), form.robot.geometry
    for _ in range(10):
        x = rng.normal(size=NODE) * [0.2, 1, 5, *[0.5] * 10, *[1] * 10, *[2] * 10, 0]
        x[[6, 11]], x[-1] = rng.uniform(0.3, 1.5, 2), 1.0  # bent knees; a step of 1 s
        _, efforts, force, moment = (value.full().ravel() for value in rooted(x))
        joints = plant(robot).slides.joint_motion(x[3:13], x[13:23], x[23:33])
        needed, jacobian = plant(robot).inverse(standing(robot, side, x[:3], *joints), side)
        if side == "right":
            efforts, force, moment = reflected(efforts, geometry), POLAR * force, AXIAL * moment
        left = needed - jacobian.T @ np.concatenate([force, moment])
        driven = np.delete(left, [11, 17])  # the upper feet are held
        expected = np.concatenate([np.zeros(6), efforts])
        np.testing.assert_allclose(driven, expected, rtol=0, atol=1e-9 * np.abs(needed).max())


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("side", SIDES)
def test_energies_and_the_equation_of_motion(side, robot):
    rng, rooted = np.random.default_rng(1), RootedRobot(ROBOTS[robot])
    place = ca.Function("place", [rooted.q, rooted.v], [rooted.center_of_mass[0]])
    model, data = plant(robot).model, plant(robot).data
    for _ in range(5):
        q, v, a = rng.standard_normal((3, NUM)) * [[0.3], [1.0], [5.0]]
        mass, bias = (value.full() for value in rooted.dynamics(q, v))
        state = standing(robot, side, np.array([q[0], v[0], a[0]]), q[1:], v[1:], a[1:])
        needed, jacobian = plant(robot).inverse(state, side)
        wrench = np.linalg.solve(jacobian[:, :6].T, needed[:6])
        efforts = np.delete(needed - jacobian.T @ wrench, [11, 17])[6:]
        moment = wrench[3]
        if side == "right":
            moment, efforts = -moment, reflected(efforts, ROBOTS[robot].geometry)
        np.testing.assert_allclose(mass @ a + bias[:, 0], [moment, *efforts], atol=1e-8)
        data.qpos[:], data.qvel[:] = state.qpos, state.qvel
        mujoco.mj_forward(model, data)
        mujoco.mj_energyVel(model, data)
        assert v @ mass @ v / 2 == pytest.approx(data.energy[1], rel=1e-9)
        mujoco.mj_energyPos(model, data)
        total = model.body_subtreemass[1] * GRAVITY
        assert total * float(place(q, v)[2]) == pytest.approx(data.energy[0], rel=1e-9)


def test_random_motions_of_the_virtual_knee():
    """The thigh is longer than the shank, so that no term vanishes."""
    robot = config().robot
    robot = replace(robot, virtual_knee=replace(robot.sliding_leg, thigh_length=0.39))
    rng = np.random.default_rng(0)
    pinocchio = PinRobot(robot, "knee")
    rooted = inverse_dynamics(Formulation(robot, replace(config().gait, dynamics="knee")))
    for _ in range(20):
        x = rng.normal(size=33) * [0.2, 1, 5, *[0.5] * 10, *[1] * 10, *[2] * 10]
        x[[6, 11]] = rng.uniform(0.3, 1.5, 2)  # knees: the slide's force needs them bent
        joints = pinocchio.joint_motion(x[3:13], x[13:23], x[23:33])
        forces, wrench = pinocchio.inverse_dynamics(pinocchio.standing(x[:3], *joints))
        expected = [*pinocchio.work(x[3:13], forces), wrench[:3], wrench[3:]]
        for value, right in zip(rooted(np.append(x, 1.0)), expected, strict=True):
            np.testing.assert_allclose(np.array(value).ravel(), right, atol=1e-8)
