"""Rules of the page: its sections, and the frames of its videos."""

from collections.abc import Iterable

from slider.config.report import PROTOCOL_SECTIONS, SECTION_INPUTS, ReportConfig
from slider.config.validation.checks import one_of, require


def check_report(report: ReportConfig, protocols: Iterable[str], control_period: float) -> None:
    """Sections and frames; ``protocols`` are the names of those beside Table 1's."""
    _sections(report.sections, protocols)
    _frame_rate(report.video.frame_rate, control_period, "report.video.frame_rate")


def _sections(sections: list[str], protocols: Iterable[str]) -> None:
    """A section about a protocol needs that protocol."""
    key = "report.sections"
    absent = {*PROTOCOL_SECTIONS} - {*protocols}
    known = [name for name in SECTION_INPUTS if name not in absent]
    for name in sections:
        one_of(key, name, known)


def _frame_rate(rate: int, control_period: float, key: str) -> None:
    """Every frame shows the end of a control step."""
    steps = 1.0 / (control_period * rate)
    expected = f"a divisor of the control rate ({1 / control_period:g} 1/s)"
    require(steps >= 1 and abs(steps - round(steps)) < 1e-9, key, expected, rate)
