"""The section about the ablation, from the files of its stage."""

import pytest

from slider.reports.page import render_page
from slider.reports.sections import ablation
from tests.reports.sections.sources import sources
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
    return ablation.section(sources({"ablation": [out]}, configuration={"ablation": settings}))


def texts(table):
    return [[cell.text for cell in row] for row in table.rows]


def test_says_what_the_variants_are_and_when_they_learned(section):
    assert texts(section.values["variants"]) == [
        ["as it is", "0.75 (0.5–1)", "none"],
        ["hard", "never", "gait.cost=torque env=paper"],
    ]


def test_has_a_table_per_number_with_the_mean_as_key(section):
    tables = {table.caption: table for table in section.values["tables"]}
    errors = tables["Velocity MSE from 2 s on [m²/s²]"]
    assert errors.columns == ["variant", "0.2 m/s", "0.8 m/s"]
    assert texts(errors)[1] == ["hard", "0.35 (0.3–0.4)", "∞ (0.3–∞)"]
    assert errors.rows[0][1].key == pytest.approx(0.15)
    gait = texts(tables["Variance of the forward velocity [m²/s²]"])[-1]
    assert gait[0] == "the library's gait"
    assert all(float(text) >= 0 for text in gait[1:])


def test_the_page_has_the_figure(section):
    html = render_page("title", {}, {"ablation": section})
    assert '<img class="card" src="data:image/svg+xml;base64,' in html
    assert "mean of 2 seeds" in html
    assert "not run" not in html
