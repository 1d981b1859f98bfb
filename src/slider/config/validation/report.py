"""Checks of the page: its sections, and films that an encoder can write."""

from collections.abc import Iterable

from slider.config.report import PROTOCOL_SECTIONS, SECTION_INPUTS, ReportConfig
from slider.config.validation.checks import (
    at_least,
    distinct,
    one_of,
    positive,
    require,
    some,
)
from slider.config.video import RENDERERS, VideoConfig


def check_report(report: ReportConfig, protocols: Iterable[str], control_period: float) -> None:
    """Sections and video; ``protocols`` are the names of those beside Table 1's."""
    _sections(report.sections, protocols)
    _video(report.video, control_period, "report.video")


def _sections(sections: list[str], protocols: Iterable[str]) -> None:
    """A section about a protocol needs that protocol."""
    key = "report.sections"
    some(key, sections, "section")
    absent = {*PROTOCOL_SECTIONS} - {*protocols}
    known = [name for name in SECTION_INPUTS if name not in absent]
    for name in sections:
        one_of(key, name, known)
    distinct(key, sections, "each section once")


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
