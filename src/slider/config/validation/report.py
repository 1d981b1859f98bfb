"""Checks of the page: its sections, and films that an encoder can write."""

from slider.config.report import ReportConfig
from slider.config.validation.checks import (
    at_least,
    distinct,
    one_of,
    positive,
    require,
    some,
)
from slider.config.video import RENDERERS, VideoConfig


def check_report(report: ReportConfig, control_period: float) -> None:
    """Sections and video; whoever lays out the jobs knows which sections there are."""
    some("report.sections", report.sections, "section")
    distinct("report.sections", report.sections, "each section once")
    _video(report.video, control_period, "report.video")


def _video(video: VideoConfig, control_period: float, key: str) -> None:
    one_of(f"{key}.renderer", video.renderer, RENDERERS)
    positive(f"{key}.duration", video.duration)
    for name in ("width", "height"):  # H.264 stores colours at half the resolution
        size = getattr(video, name)
        require(32 <= size <= 1920 and size % 2 == 0, f"{key}.{name}", "even, 32 to 1920", size)
    _frame_rate(video.frame_rate, control_period, f"{key}.frame_rate")
    require(0 <= video.quality <= 51, f"{key}.quality", "0 to 51", video.quality)
    at_least(f"{key}.seed", video.seed, 0)


def _frame_rate(rate: int, control_period: float, key: str) -> None:
    """Every frame shows the end of a control step."""
    at_least(key, rate, 1)
    steps = 1.0 / (control_period * rate)
    expected = f"a divisor of the control rate ({1 / control_period:g} 1/s)"
    require(steps >= 1 and abs(steps - round(steps)) < 1e-9, key, expected, rate)
