"""The section about velocity tracking."""

from dataclasses import replace

import numpy as np

from slider.config.report import ReportConfig
from slider.evaluation.results import Evaluation, Robots
from slider.reports.page import content
from slider.reports.sections.sources import Sources
from slider.reports.table import Text
from tests.reports.sections.sources import VIDEO, html, pick, sources


def test_commands_none_of_which_is_evaluated_are_said(monkeypatch):
    one = Evaluation("policy", 1.0, Robots({"survived": np.array([True])}), label="policy (ours)")
    monkeypatch.setattr(Sources, "evaluations", lambda self, name: [one])
    report = ReportConfig(["tracking"], [7.0, 0.25], VIDEO)
    section = content("tracking", replace(sources({}), report=report))
    (note,) = pick(section, Text)
    expected = "Not evaluated in this run, and therefore not drawn: 7.0, 0.25 m/s."
    assert note.markdown == expected
    assert expected in html(tracking=section)
