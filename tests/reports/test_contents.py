"""Blocks of the page's sections from inputs whose answers are known."""

import json

import numpy as np
import pandas as pd

from slider.reports import contents
from slider.reports.figures.style import style
from slider.reports.figures.walking import draw_overview, draw_training
from slider.reports.sections import SECTIONS
from slider.reports.table import Table, Text, inline
from slider.reports.table1 import paper_rows
from slider.robot.names import VELOCITY
from slider.training.results import Training
from slider.verification.quantities import QUANTITIES
from slider.verification.summary import failures, worst, write_csv
from tests.reports.sources import html, pick, sources


def test_every_section_has_its_function():
    assert all(callable(getattr(contents, name)) for name in SECTIONS)


def verified(folder, bound: float):
    """The section for two gaits and a bound of ``periodicity``; one has no ``roll_end``."""
    first = dict.fromkeys(QUANTITIES, 0.5) | dict.fromkeys(VELOCITY, 0.0)
    second = dict.fromkeys(QUANTITIES, 0.25) | dict(zip(VELOCITY, (0.5, 0.1, 0.3), strict=True))
    rows = pd.DataFrame([first, second | {"periodicity": 0.9, "roll_end": None}])
    bounds: dict[str, float | None] = dict.fromkeys(QUANTITIES) | {"periodicity": bound}
    failed = failures(rows, bounds)
    write_csv(folder / "verification.csv", rows, failed)
    facts = {"failures": [one.text for one in failed], "quantities": worst(rows, bounds)}
    (folder / "verification.json").write_text(json.dumps({"gaits": 2, **facts}))
    (folder / "verification_maps.svg").write_text("<svg/>")
    inputs = {name: [folder] for name in ("verification", "verification_maps")}
    return list(contents.verification(sources(inputs)))


def test_the_verification_names_failures(tmp_path):
    section = verified(tmp_path, 0.1)
    lines = pick(section, Text)[2].markdown.splitlines()
    assert [line.partition(",")[0] for line in lines] == ["* gait (0", "* gait (0.5"]
    (bounds,) = pick(section, Table)
    table = {row[1].text: [cell.text for cell in row] for row in bounds.rows}
    assert set(table) == {f"`{name}`" for name in QUANTITIES}
    assert table["`periodicity`"][4:] == ["0.9", "≤ 0.1", "NO", "0.5, 0.1, 0.3 rad/s", "0.7"]
    assert table["`roll_end`"][4:] == ["0.5", "–", "–", "0, 0", "0.5"]
    assert '<span class="failed">NO</span>' in html(verification=section)


def test_the_verification_holds(tmp_path):
    shown = html(verification=verified(tmp_path, 1.0))
    assert "All 1 bounds hold." in shown
    assert ">NO<" not in shown
    assert 'src="data:image/svg+xml,%3Csvg/%3E"' in shown


def row(speed: float, success: float, error: float) -> dict:
    about = {"controller": "policy", "label": "policy (ours)", "source": "measured"}
    return about | {"speed": speed, "success_rate": success, "mse_steady": error}


def test_the_finding_has_the_worst_numbers_and_the_papers():
    rows = [row(0.2, 1.0, 0.001), row(3.0, 0.998, 0.0123), *paper_rows()]
    sentence = contents.finding(rows)
    for part in ("**99.8 %**", "**0.0123 m²/s²**", "up to 3.0 m/s (guided RL (paper): 73.1 %"):
        assert part in sentence


def test_the_overview_draws_every_controller_and_leaves_infinite_errors_out():
    with style():
        success, errors = draw_overview([row(0.2, 1.0, 0.001), row(3.0, 0.5, np.inf)]).axes
    np.testing.assert_allclose(success.lines[0].get_ydata(), [100, 50])
    np.testing.assert_array_equal(errors.lines[0].get_ydata(), [0.001, np.nan])


def test_a_training_is_drawn_with_gaps_where_nobody_survived(tmp_path):
    file = tmp_path / "selection.csv"
    file.write_text("iteration,value,success,speed_error\n5,10,0,\n10,5.3,0.5,0.1\n")
    with style():
        axes = draw_training(Training.load(tmp_path)).axes
    shown = {panel.get_title(): panel.lines[0].get_ydata() for panel in axes}
    np.testing.assert_array_equal(shown["speed error [m/s]"], [np.nan, 0.1])
    np.testing.assert_array_equal(shown["score"], [10.0, 5.3])


def test_markdown_within_a_paragraph():
    assert inline("`a<b` **x** \\* y") == "<code>a&lt;b</code> <strong>x</strong> * y"
