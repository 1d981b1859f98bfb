"""The whole-body QP: cost, limits and contacts are those of the full accelerations."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from slider.control import qp
from slider.control.whole_body.model import Dynamics
from slider.control.whole_body.problem import WholeBody
from slider.control.whole_body.tasks import BodyControl
from slider.env.starts import at_rest
from slider.robot import names
from tests.control.walking import nominal
from tests.env.synthetic import TRANSMISSION, config, robot_config

CONTROL = config().control["mpc_wbc_tuned"].whole_body
COUNT = 3
MOTOR = TRANSMISSION.torque[3]  # of a capstan [N m]


@pytest.fixture
def dynamics() -> Dynamics:
    """Robots near standing that move a little."""
    rng = np.random.default_rng(5)
    qpos, _ = at_rest(robot_config(), config().evaluation.start, rng, COUNT)
    return nominal().evaluate(qpos, 0.1 * rng.standard_normal((COUNT, 18)))


def build(dynamics: Dynamics, feet: np.ndarray, acceleration=(0.0, 0.0, 0.0), settings=CONTROL):
    motion = BodyControl(robot_config(), settings, search=0.1, height=0.65)
    body = WholeBody(robot_config(), settings)
    zero = np.zeros(COUNT)
    parts = [
        (dynamics.com_jacobian, acceleration - dynamics.com_bias, np.ones(3)),
        motion.base(dynamics, zero, zero),
        motion.stance(dynamics, feet, np.zeros(feet.shape)),
    ]
    return body, parts, body.build(dynamics, parts, feet, np.ones(feet.shape, dtype=bool))


DRIVEN = np.array([6, 7, 8, 9, 10, 12, 13, 14, 15, 16])
FREE = np.array([0, 1, 2, 3, 4, 5, 11, 17])  # base and upper feet


def follows(dynamics: Dynamics, contact: np.ndarray, i: int) -> np.ndarray:
    """q̈ (18, size + 1) of robot ``i`` from (f, q̈ₐ, 1), by the equations of motion."""
    mass, jacobian, driven = dynamics.mass_matrix[i], contact[i], np.eye(18)[:, DRIVEN]
    right = np.hstack([jacobian.T, -mass @ driven, -dynamics.bias[i][:, None]])[FREE]
    found = np.hstack([np.zeros((18, len(jacobian))), driven, np.zeros((18, 1))])
    found[FREE] = np.linalg.inv(mass[np.ix_(FREE, FREE)]) @ right
    return found


BOTH, LEFT = np.tile([0, 1], (COUNT, 1)), np.zeros((COUNT, 1), dtype=int)


def solution(problem, i: int) -> np.ndarray:
    parts = (problem.hessian, problem.gradient, problem.rows, problem.lower, problem.upper)
    y, solved = qp.solve(*(part[[i]] for part in parts))
    assert solved[0]
    return y[0]


@pytest.mark.parametrize("feet", [BOTH, LEFT], ids=["both", "left"])
def test_cost_and_limits_are_those_of_the_full_accelerations(dynamics, feet):
    """Σ w (J q̈ − b)² + ρ y², and motor torques of M q̈ + h − Jᵀf, of any y."""
    body, parts, problem = build(dynamics, feet, (0.5, 0.1, 0.0))
    jacobian, target = (np.concatenate([part[k] for part in parts], axis=1) for k in (0, 1))
    weight = np.concatenate([part[2] for part in parts])
    contact, (of_joints, of_forces) = body.contact_jacobian(dynamics, feet), CONTROL.regularisation
    num_forces, rng = contact.shape[1], np.random.default_rng(2)
    damping = np.array([of_forces] * num_forces + [of_joints] * 10)

    def cost(i: int, y: np.ndarray) -> float:
        error = jacobian[i] @ (follows(dynamics, contact, i) @ np.append(y, 1.0))
        error -= target[i]
        return 0.5 * (weight @ error**2 + damping @ y**2)

    for i in range(COUNT):
        hessian, gradient = problem.hessian[i], problem.gradient[i]
        for y in rng.normal(size=(3, num_forces + 10)):
            change = cost(i, y) - cost(i, np.zeros_like(y))
            assert 0.5 * y @ hessian @ y + gradient @ y == pytest.approx(change, rel=1e-9)
            acceleration = follows(dynamics, contact, i) @ np.append(y, 1.0)
            efforts = dynamics.mass_matrix[i] @ acceleration + dynamics.bias[i]
            efforts -= contact[i].T @ y[:num_forces]
            found = problem.efforts[i] @ np.append(y, 1.0)
            np.testing.assert_allclose(found, efforts[DRIVEN], rtol=1e-9, atol=1e-9)
            # The motors turn slowly: the limits are those of the torque.
            left = problem.upper[i, num_forces : num_forces + 10] - problem.rows[i, :10] @ y
            torques = TRANSMISSION.torques(efforts[None, 6:])[0]
            np.testing.assert_allclose(TRANSMISSION.torque - left, torques, rtol=1e-9, atol=1e-9)


def test_forces_lie_in_the_friction_cone_and_carry_the_weight(dynamics):
    slippery = replace(CONTROL, friction=0.02)
    _, _, problem = build(dynamics, BOTH, (0.5, 0.0, 0.0), slippery)
    for i in range(COUNT):
        force = solution(problem, i)[:12].reshape(4, 3)
        assert (force[:, 2] > -1e-6).all()
        assert (np.hypot(force[:, 0], force[:, 1]) <= 0.02 * force[:, 2] + 1e-4).all()
        bound = 0.02 / np.sqrt(2) * force[:, 2:]
        assert (np.abs(force[:, :2]) <= bound + 1e-4).all()
        assert np.isclose(np.abs(force[:, :2]), bound, atol=1e-5).any(), "a side is active"
    _, _, still = build(dynamics, BOTH)
    weight = nominal().mass * 9.81
    total = solution(still, 0)[:12].reshape(4, 3).sum(axis=0)
    assert total[2] == pytest.approx(weight, rel=0.1)


def test_a_foot_in_the_air_carries_nothing(dynamics):
    body, parts, _ = build(dynamics, BOTH)
    loaded = np.tile([True, False], (COUNT, 1))
    problem = body.build(dynamics, parts, BOTH, loaded)
    for i in range(COUNT):
        force = solution(problem, i)[:12].reshape(4, 3)
        np.testing.assert_allclose(force[2:], 0.0, atol=1e-9)
        assert force[:2, 2].sum() > 10


def test_torques_stay_within_a_share_of_the_limits(dynamics):
    settings = replace(CONTROL, effort_share=0.16)
    body, _, problem = build(dynamics, BOTH, (0.0, 0.0, 8.0), settings)
    efforts, solved = body.solve(problem)
    assert solved.all()
    torques = TRANSMISSION.torques(efforts)
    assert (np.abs(torques) <= 0.16 * TRANSMISSION.torque + 1e-4).all()
    capstans = np.abs(torques.reshape(COUNT, 2, 5)[..., 3:])
    assert capstans.max() == pytest.approx(0.16 * MOTOR, abs=1e-4), "a limit is active"


def test_fast_motors_have_less_torque(dynamics):
    """At 2.4 m/s capstan motors turn with 96 rad/s of 120: a fifth of the stall torque is left."""
    qvel = np.zeros_like(dynamics.qvel)
    qvel[:, [6 + 3, 6 + 9]] = 2.4
    body, _, problem = build(replace(dynamics, qvel=qvel), BOTH, (0.0, 0.0, 60.0))
    efforts, solved = body.solve(problem)
    assert solved.all()
    capstans = TRANSMISSION.torques(efforts).reshape(COUNT, 2, 5)[..., 3:]
    assert capstans.max() == pytest.approx(0.2 * 2 * MOTOR, abs=1e-4)
    assert capstans.min() > -MOTOR


def test_contact_points_are_the_ends_of_the_line(dynamics):
    body = WholeBody(robot_config(), CONTROL)
    qpos, _ = at_rest(robot_config(), config().evaluation.start, np.random.default_rng(5), COUNT)
    data = mujoco.MjData(nominal().model)
    data.qpos[:] = qpos[0]
    mujoco.mj_kinematics(nominal().model, data)
    mujoco.mj_comPos(nominal().model, data)
    found = body.contact_jacobian(dynamics, BOTH)[0].reshape(2, 2, 3, 18)
    for leg, side in enumerate(names.SIDES):
        foot = data.body(names.foot(side))
        for end, x in enumerate((-0.085, 0.085)):
            point = foot.xpos + foot.xmat.reshape(3, 3) @ [x, 0.0, -0.045]
            jacobian = np.zeros((3, 18))
            mujoco.mj_jac(nominal().model, data, jacobian, None, point, foot.id)
            np.testing.assert_allclose(found[leg, end], jacobian, atol=1e-12)
