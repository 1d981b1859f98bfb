"""Comparisons of gaits on several meshes whose answers are known."""

import casadi as ca
import numpy as np
import pytest

from slider.config.convert import from_dict
from slider.config.gait import FormulationConfig
from slider.gait.formulation import Formulation
from slider.gait.problem import build
from slider.gait.solve import Nlp
from slider.gait.stage import gait_arrays
from slider.gait.study import MeshGait
from tests.gait.gaits import config, problem, section, solved


def gait(nodes: int, offset: float = 0.0, roll: float = 0.0) -> MeshGait:
    """All joints and torques are the phase; a bump of the roll at mid-step and at its end."""
    phase = np.linspace(0.0, 1.0, nodes)
    joints = np.tile(phase[None, :, None], (2, 1, 10))
    bump = roll * np.isin(phase, (0.5, 1.0)) * (1.0 + (phase == 0.5))
    return MeshGait(joints + offset, joints.copy(), np.tile(bump, (2, 1)), 0.4)


@pytest.mark.parametrize("nodes", [5, 21])
def test_the_torque_cost_of_a_linear_torque(nodes):
    assert gait(nodes).torque_cost == pytest.approx(2 * 10 / 3)


def test_the_torque_cost_is_the_optimisation_s_own(tmp_path):
    """The cost ``torque`` of the nonlinear programme, at a solution for another cost."""
    given = section(0.4, 0.0)["formulation"] | {"cost": "torque"}
    other = build(Formulation(config().robot, from_dict(FormulationConfig, given)))
    variables = solved(0.4, 0.0).variables
    for name, array in gait_arrays(problem(), solved(0.4, 0.0), "exact").items():
        np.save(tmp_path / f"{name}.npy", array)
    x, p = ca.MX.sym("x", len(variables)), ca.MX.sym("p", 3)
    objective = ca.Function("f", [x, p], [Nlp(other).objective_and_rows(x, p)[0]])
    expected = float(objective(variables, [0.4, 0.0, 0.0])) / 1e-3
    assert MeshGait.load(tmp_path).torque_cost == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("meshes", [(5, 9), (9, 5), (7, 11), (5, 5)])
def test_meshes_are_compared_at_common_phases(meshes):
    found = gait(meshes[0], 0.03, 0.01).difference(gait(meshes[1]))
    assert found["joints_difference"] == pytest.approx(0.03)
    assert found["roll_difference"] == pytest.approx(0.02)
    assert found["roll_end_difference"] == pytest.approx(0.01)
