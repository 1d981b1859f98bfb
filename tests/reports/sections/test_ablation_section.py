"""The section about the ablation, from the files of its stage."""

import pytest

from slider.reports.page import content
from slider.reports.table import Table
from tests.reports.sections.sources import html, pick, sources
from tests.reports.test_ablation import SECTION, inputs, out

__all__ = ["inputs", "out"]  # fixtures: a finished stage


@pytest.fixture
def section(out):
    settings = {
        "run": ["default", "hard"],
        "seeds": [1, 2],
        "samples": 4_000_000,
        "variants": SECTION["variants"] | {"other": {"label": "not run", "overrides": []}},
    }
    given = sources({"ablation": [out]}, configuration={"ablation": settings})
    return content("ablation", given)


def texts(table):
    return [[cell.text for cell in row] for row in table.rows]


def test_says_what_the_variants_are_and_when_they_learned(section):
    assert texts(pick(section, Table)[0]) == [
        ["as it is", "0.750 (0.500–1.00)", "none"],
        ["hard", "never", "`gait.cost=torque` `env=paper`"],
    ]


def test_has_a_table_per_number_with_the_mean_as_key(section):
    tables = {table.caption: table for table in pick(section, Table)}
    errors = tables["Velocity MSE after the warm-up [m²/s²]"]
    assert errors.columns == ["variant", "0.2 m/s", "0.8 m/s"]
    assert texts(errors)[1] == ["hard", "0.350 (0.300–0.400)", "∞ (0.300–∞)"]
    assert errors.rows[0][1].key == pytest.approx(0.15)
    gait = texts(tables["Variance of the forward velocity [m²/s²]"])[-1]
    assert gait[0] == "the library's gait"
    assert all(float(text) >= 0 for text in gait[1:])


def test_the_page_has_the_figure(section):
    page = html(ablation=section)
    assert '<img class="card" src="data:image/svg+xml;base64,' in page
    assert "<code>env=paper</code>" in page
    assert "mean of 2 seeds" in page
    assert "not run" not in page
