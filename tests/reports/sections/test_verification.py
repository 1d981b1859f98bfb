"""The section about the independent checks, from the files of their stage."""

import json

import numpy as np
import pytest

from slider.reports.page import render_page
from slider.reports.sections import verification
from slider.verification.quantities import QUANTITIES
from slider.verification.summary import Row, failures, worst, write_csv, write_json
from tests.reports.sections.sources import sources


def rows() -> list[Row]:
    first = dict.fromkeys(QUANTITIES, 0.5)
    second = dict.fromkeys(QUANTITIES, 0.25) | {"mirror_cost": 0.9, "return_map": 20.0}
    second.pop("roll_end")  # some quantities do not exist for every gait
    return [Row((0.0, 0.0), first), Row((0.5, 0.1), second)]


@pytest.fixture
def found(tmp_path):
    """A function from the bound of ``mirror_cost`` to the section's values."""

    def build(bound: float):
        bounds: dict[str, float | None] = dict.fromkeys(QUANTITIES) | {"mirror_cost": bound}
        failed = failures(rows(), bounds)
        write_csv(tmp_path / "verification.csv", rows(), failed)
        content = {"failures": [str(f) for f in failed], "quantities": worst(rows(), bounds)}
        write_json(tmp_path / "verification.json", {"gaits": 2, **content})
        return verification.section(sources({"verification": [tmp_path]}))

    return build


def test_names_what_failed(found):
    section = found(0.1)
    assert section.values["failures"] == [
        "gait (0, 0) m/s, mirror_cost: expected ≤ 0.1 -, found 0.5",
        "gait (0.5, 0.1) m/s, mirror_cost: expected ≤ 0.1 -, found 0.9",
    ]
    table = {row[1].text: [cell.text for cell in row] for row in section.values["table"].rows}
    assert set(table) == set(QUANTITIES)
    assert table["mirror_cost"][4:] == ["0.9", "≤ 0.1", "NO", "0.5, 0.1", "0.7"]
    assert table["roll_end"][4:] == ["0.5", "–", "–", "0, 0", "0.5"]
    html = render_page("title", {}, {"verification": section})
    assert "2 values are beyond their bounds" in html
    assert '<td data-key="" class="failed">NO</td>' in html


def test_says_that_all_bounds_hold(found):
    html = render_page("title", {}, {"verification": found(1.0)})
    assert "All 1 bounds hold." in html
    assert ">NO<" not in html


def test_maps_have_a_square_per_gait_and_a_gap_where_there_is_no_value(found):
    (chart,) = found(1.0).values["charts"]
    figure = json.loads(chart.spec)
    marker = figure["data"][0]["marker"]
    np.testing.assert_allclose(marker["color"], [0.5, 20.0])
    assert marker["colorbar"]["title"]["text"] == "return_map [1]"
    buttons = {b["label"]: b["args"][0] for b in figure["layout"]["updatemenus"][0]["buttons"]}
    assert buttons["roll_end [rad]"]["marker.color"] == [[0.5, None]]
    assert buttons["roll_end [rad]"]["text"] == [["0.5", "–"]]
