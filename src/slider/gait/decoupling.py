"""The decoupling matrix of the virtual constraints along a gait.

Outputs have relative degree two, ÿ = L_f² y + L_g L_f y u with L_g L_f y = H' M⁻¹ B, H' the columns
of H for roll and joints. Input-output linearisation needs its inverse. Joints as outputs never lose
it: theirs is a principal block of M⁻¹. Absolute angles can, so that it is theirs that is stored.
Where the hip is the phase, its forward position p takes the place of the stance ankle, whose effort
drives the phase: ∇p M⁻¹ B is the row of p̈, the rate of the output of relative degree one.
"""

import casadi as ca
import numpy as np

from slider.config.robot import Mechanism
from slider.gait.outputs import ANKLE, YAW, output_matrix
from slider.gait.rooted import RootedRobot
from slider.robot.names import SIDES
from slider.robot.transmission import by_motor, leg_matrix

NAME = "decoupling"


def decoupling(robot: Mechanism, q: np.ndarray, by_hip: bool = False) -> np.ndarray:
    """Least singular value [rad/s², m/s²] and condition number (S, 2) at q (S, 11).

    Inputs are the motors' torques as shares of their limits: the least singular value is the
    acceleration of the outputs that full torques give in the worst direction.
    """
    rooted = RootedRobot(robot)
    masses = rooted.dynamics.map(len(q))(q.T, np.zeros(q.T.shape))[0].full()
    mass = masses.reshape(q.shape[1], len(q), q.shape[1]).transpose(1, 0, 2)
    rows = np.tile(np.delete(output_matrix("absolute"), YAW, axis=1), (len(q), 1, 1))
    if by_hip:
        hip = ca.gradient(rooted.poses(rooted.q)["base"].origin[0], rooted.q)
        rows[:, ANKLE] = ca.Function("hip", [rooted.q], [hip]).map(len(q))(q.T).full().T
    limits = np.array([drive.torque for drive in by_motor(robot.drives)])
    motors = np.kron(np.eye(len(SIDES)), leg_matrix(robot.capstan).T * limits)
    inputs = np.concatenate([np.zeros((1, motors.shape[1])), motors])
    values = np.linalg.svd(rows @ np.linalg.solve(mass, inputs[None]), compute_uv=False)
    with np.errstate(divide="ignore"):
        return np.stack([values[:, -1], values[:, 0] / values[:, -1]], axis=1)


def shortfall(values: np.ndarray, least: float) -> float:
    """By how much the least singular value of a gait (S, 2) misses its bound [rad/s², m/s²]."""
    return float(max(0.0, least - values[:, 0].min()))
