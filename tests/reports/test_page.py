"""Sections of the page, and Markdown as HTML."""

import json

import numpy as np

from slider.core.job import Job
from slider.reports import page
from slider.reports.figures.style import style
from slider.reports.figures.walking import draw_training
from slider.reports.film import annotate
from slider.reports.html import html
from slider.reports.sections import SECTIONS
from slider.reports.video import ABOUT, FILM, POSTER
from slider.training.results import Training


def test_every_section_is_written_somewhere():
    assert {name for name, section in SECTIONS.items() if not section.documents} == {*page.WRITERS}
    for section in SECTIONS.values():
        needed = {name.rstrip("?") for name in section.needs}
        assert {place.partition("/")[0] for place in section.documents} <= needed


def test_a_report_is_shown_with_its_pictures(tmp_path):
    """As written by the stage: the page repeats no number on its own."""
    report, out = tmp_path / "sweep", tmp_path / "out"
    report.mkdir()
    out.mkdir()
    table = "| v | e |\n|---|---|\n| 0.2 | **0.1 ± 0.2** |"
    parts = ["# Speeds: sweep", "![Sweep](figures/sweep.svg)", "## MSE", table]
    (report / "sweep.md").write_text("\n\n".join(parts))
    (report / "sweep.svg").write_text("<svg/>")
    section = {"report": {"sections": ["sweep", "tracking"]}}
    page.run(section, {"sweep": [report]}, out, Job(out))
    shown = (out / page.PAGE).read_text()
    assert '<img src="data:image/svg+xml;base64,PHN2Zy8+" alt="Sweep">' in shown
    assert "<h3>MSE</h3>" in shown
    assert '<td class="number"><strong>0.1 ± 0.2</strong></td>' in shown
    assert "Speeds: sweep" not in shown, "the section's heading is in its place"
    assert "This run has none." in shown, "of the tracking's speeds none is evaluated"


def test_films_are_within_the_page_and_say_how_the_robot_did(tmp_path):
    about = {"controller": "policy", "label": "ours", "speed": 0.0, "terrain": "", "fell_at": None}
    for name, more in (("a", {"mean_velocity": -0.001}), ("b", {"fell_at": 1.25})):
        (tmp_path / name).mkdir()
        facts = about | {"mean_velocity": 0.0} | more
        (tmp_path / name / ABOUT).write_text(json.dumps(facts))
        (tmp_path / name / FILM).write_bytes(b"film")
        (tmp_path / name / POSTER).write_bytes(b"poster")
    inputs = {"videos": [tmp_path / "a", tmp_path / "b"]}
    made = page.Page({}, inputs, tmp_path, Job(tmp_path))
    shown = html("\n\n".join(page.videos(made)), made.files)
    assert "ours: walks at 0.00 m/s</figcaption>" in shown
    assert "ours: falls after 1.2 s</figcaption>" in shown
    assert shown.count('src="data:video/mp4;base64,ZmlsbQ=="') == 2
    assert '<div class="pictures"><figure>' in shown


def test_a_training_is_drawn_with_gaps_where_nobody_survived(tmp_path):
    file = tmp_path / "selection.csv"
    file.write_text("iteration,value,success,speed_error\n5,10,0,\n10,5.3,0.5,0.1\n")
    with style():
        axes = draw_training(Training.load(tmp_path)).axes
    shown = {panel.get_title(): panel.lines[0].get_ydata() for panel in axes}
    np.testing.assert_array_equal(shown["speed error [m/s]"], [np.nan, 0.1])
    np.testing.assert_array_equal(shown["score"], [10.0, 5.3])


def test_the_facts_are_within_the_picture():
    facts = "command 3.00 m/s   actual 2.60 m/s   t = 10.0 s"
    image = annotate(np.zeros((300, 480, 3), np.uint8), "MPC + WBC, tuned", facts, False)
    row = np.asarray(image)[-24:-8].max(axis=(0, 2)) > 128  # columns with ink
    ink = np.flatnonzero(row)
    assert ink[-1] < 470
