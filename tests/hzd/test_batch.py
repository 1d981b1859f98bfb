"""Functions of many rows at once against CasADi's own evaluation of each."""

import shutil

import casadi as ca
import numpy as np
import pytest

from slider.core.casadi_code import Compiled, interpreted
from slider.core.job import Job
from slider.hzd.model import Batch


@pytest.mark.parametrize(
    "compiled",
    [
        False,
        pytest.param(
            True, marks=pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
        ),
    ],
)
def test_matrices_and_columns_of_any_number_of_rows(compiled, tmp_path):
    functions = Compiled(Job(tmp_path, cache=tmp_path), "tests") if compiled else interpreted
    x, y = ca.SX.sym("x", 3), ca.SX.sym("y", 2)
    results = [ca.sin(x) * y[0], x @ y.T, ca.vertcat(y[1] ** 2, 0)]
    batch, single = Batch([x, y], results, functions), ca.Function("single", [x, y], results)
    assert len(list(tmp_path.glob("*.so"))) == compiled
    rng = np.random.default_rng(0)
    for n in (1, 4, 2, 0):
        a, b = rng.normal(size=(n, 3)), rng.normal(size=(2, n)).T  # the second not in C's order
        found = batch(a, b)
        assert [part.shape for part in found] == [(n, 3), (n, 3, 2), (n, 2)]
        for row in range(n):
            for part, expected in zip(found, single(a[row], b[row]), strict=True):
                np.testing.assert_array_equal(part[row], expected.full().reshape(part[row].shape))


def test_results_stay_when_it_is_called_again():
    x = ca.SX.sym("x", 1)
    batch = Batch([x], [2 * x])
    first = batch(np.ones((3, 1)))[0]
    batch(np.zeros((3, 1)))
    np.testing.assert_array_equal(first, 2.0)
