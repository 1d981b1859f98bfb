"""The section about the independent checks, from the files of their stage."""

import pytest

from slider.reports.page import content
from slider.reports.table import Table, Text
from slider.verification.quantities import QUANTITIES
from slider.verification.summary import Row, failures, worst, write_csv, write_json
from tests.reports.sections.sources import html, pick, sources


def rows() -> list[Row]:
    first = dict.fromkeys(QUANTITIES, 0.5)
    second = dict.fromkeys(QUANTITIES, 0.25) | {"mirror_cost": 0.9, "return_map": 20.0}
    second.pop("roll_end")  # some quantities do not exist for every gait
    return [Row((0.0, 0.0, 0.0), first), Row((0.5, 0.1, 0.3), second)]


@pytest.fixture
def found(tmp_path):
    """A function from the bound of ``mirror_cost`` to the section's values."""

    def build(bound: float):
        bounds: dict[str, float | None] = dict.fromkeys(QUANTITIES) | {"mirror_cost": bound}
        failed = failures(rows(), bounds)
        write_csv(tmp_path / "verification.csv", rows(), failed)
        facts = {"failures": [str(f) for f in failed], "quantities": worst(rows(), bounds)}
        write_json(tmp_path / "verification.json", {"gaits": 2, **facts})
        (tmp_path / "verification_maps.svg").write_text("<svg/>")
        inputs = {"verification": [tmp_path], "verification_maps": [tmp_path]}
        return content("verification", sources(inputs))

    return build


def test_names_what_failed(found):
    section = found(0.1)
    assert pick(section, Text)[2].markdown.splitlines() == [
        "* gait (0, 0) m/s, mirror_cost: expected ≤ 0.1 -, found 0.5",
        "* gait (0.5, 0.1) m/s, 0.3 rad/s, mirror_cost: expected ≤ 0.1 -, found 0.9",
    ]
    (bounds,) = pick(section, Table)
    table = {row[1].text: [cell.text for cell in row] for row in bounds.rows}
    assert set(table) == set(QUANTITIES)
    assert table["mirror_cost"][4:] == ["0.9", "≤ 0.1", "NO", "0.5, 0.1, 0.3 rad/s", "0.7"]
    assert table["roll_end"][4:] == ["0.5", "–", "–", "0, 0", "0.5"]
    page = html(verification=section)
    assert "2 values are beyond their bounds" in page
    assert '<td data-key="" class="failed">NO</td>' in page


def test_says_that_all_bounds_hold(found):
    page = html(verification=found(1.0))
    assert "All 1 bounds hold." in page
    assert ">NO<" not in page
    assert "data:image/svg+xml;base64,PHN2Zy8+" in page
