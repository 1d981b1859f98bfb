"""The decoupling matrix: what it means, and that a gait below its bound is refused by name."""

import json

import casadi as ca
import numpy as np

from slider.core.job import Job
from slider.gait.outputs import ANKLE, YAW, output_matrix
from slider.gait.rooted import DECOUPLING, NUM, RootedRobot, decoupling
from slider.gait.stage import REPORT, run
from slider.robot.transmission import Transmission
from tests.gait.gaits import config, section


def test_full_torques_accelerate_the_outputs_by_at_least_the_least_singular_value():
    rng = np.random.default_rng(0)
    robot, q = config().robot, 0.3 * rng.standard_normal((3, 11))
    motors = Transmission.of(robot)
    rows = np.delete(output_matrix("absolute"), YAW, axis=1)
    dynamics = RootedRobot(robot).dynamics
    for place, (least, condition) in zip(q, decoupling(robot, q), strict=True):
        mass = dynamics(place, np.zeros(11))[0].full()
        shares = rng.standard_normal((10, 2000))
        shares /= np.linalg.norm(shares, axis=0)
        joints = motors.efforts(shares.T * motors.torque)
        driven = np.delete(joints, [5, 11], axis=1).T
        gained = rows @ np.linalg.solve(mass, np.r_[np.zeros((1, driven.shape[1])), driven])
        lengths = np.linalg.norm(gained, axis=0)
        assert lengths.min() >= least * (1 - 1e-9)
        assert lengths.max() <= least * condition * (1 + 1e-9)
        assert lengths.min() < 20 * least


def test_a_gait_below_the_bound_names_it(tmp_path):
    given = section(0.6, 0.1, max_iterations=3, guesses=["cold"])
    given["solve"]["decoupling_min"] = 1e3
    run(given, {}, tmp_path, Job(tmp_path))
    report, values = (
        json.loads((tmp_path / REPORT).read_text()),
        np.load(tmp_path / f"{DECOUPLING}.npy"),
    )
    assert values.shape == (42, 2)
    assert report["residuals"][DECOUPLING] == 1e3 - values[:, 0].min() > 900
    assert report["max_violation"] == report["residuals"][DECOUPLING]


def test_the_hip_takes_the_place_of_the_stance_ankle():
    """Its row is the change of the hip's place, here by differences."""
    rng = np.random.default_rng(1)
    robot, q = config().robot, 0.2 * rng.standard_normal((2, NUM))
    rooted = RootedRobot(robot)
    hip = ca.Function("hip", [rooted.q], [rooted.poses(rooted.q)["base"].origin[0]])
    limits = Transmission.of(robot).torque
    rows = np.delete(output_matrix("absolute"), YAW, axis=1)
    for place, (least, condition) in zip(q, decoupling(robot, q, by_hip=True), strict=True):
        moved = place + 1e-6 * np.eye(NUM)
        rows[ANKLE] = [(float(hip(each)) - float(hip(place))) / 1e-6 for each in moved]
        joints = Transmission.of(robot).efforts(np.diag(limits))
        driven = np.delete(joints, [5, 11], axis=1).T
        mass = rooted.dynamics(place, np.zeros(NUM))[0].full()
        gained = rows @ np.linalg.solve(mass, np.r_[np.zeros((1, driven.shape[1])), driven])
        values = np.linalg.svd(gained, compute_uv=False)
        np.testing.assert_allclose([least, condition], [values[-1], values[0] / values[-1]], 1e-4)
        assert least > 1.0
