"""What the learning curves show."""

import base64
import json

import numpy as np
from numpy.testing import assert_array_equal

from slider.reports.sections import learning
from slider.training.results import Training


def _values(column: dict[str, str]) -> np.ndarray:
    """As plotly writes them."""
    return np.frombuffer(base64.b64decode(column["bdata"]), column["dtype"])


def test_what_a_check_did_not_find_is_not_drawn(tmp_path):
    """Nobody survived the first check."""
    file = tmp_path / "selection.csv"
    file.write_text("iteration,value,success,speed_error\n5,10,0,\n10,5.3,0.5,0.1\n")
    chart = learning.checks_chart("walking", Training.load(tmp_path))
    traces = json.loads(chart.spec)["data"]
    drawn = {trace["name"]: _values(trace["y"]) for trace in traces}
    assert_array_equal(drawn["speed error [m/s]"], [np.nan, 0.1])
    assert_array_equal(drawn["score (lower is better)"], [10.0, 5.3])
