"""The map of the gait library: a square per gait, a gap where there is no value."""

import json

import numpy as np

from slider.reports.charts import chart
from slider.reports.sections.gaits import map_figure


def test_a_map_has_a_square_per_gait_and_a_gap_where_there_is_no_value():
    velocities = np.array([[0.0, 0.0], [0.5, 0.1]])
    quantities = {"one [1]": np.array([0.5, 20.0]), "two [rad]": np.array([0.5, np.nan])}
    figure = json.loads(chart("map", map_figure(velocities, quantities), "", 360).spec)
    marker = figure["data"][0]["marker"]
    np.testing.assert_allclose(marker["color"], [0.5, 20.0])
    assert marker["colorbar"]["title"]["text"] == "one [1]"
    buttons = {b["label"]: b["args"][0] for b in figure["layout"]["updatemenus"][0]["buttons"]}
    assert buttons["two [rad]"]["marker.color"] == [[0.5, None]]
    assert buttons["two [rad]"]["text"] == [["0.5", "–"]]
