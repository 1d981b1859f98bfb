"""Rules of the page."""

from slider.config.report import ReportConfig
from slider.config.validation.checks import require


def check_report(report: ReportConfig, control_period: float) -> None:
    """Frames of the videos; whoever lays out the jobs knows which sections there are."""
    _frame_rate(report.video.frame_rate, control_period, "report.video.frame_rate")


def _frame_rate(rate: int, control_period: float, key: str) -> None:
    """Every frame shows the end of a control step."""
    steps = 1.0 / (control_period * rate)
    expected = f"a divisor of the control rate ({1 / control_period:g} 1/s)"
    require(steps >= 1 and abs(steps - round(steps)) < 1e-9, key, expected, rate)
