"""Typed settings of the page."""

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT
from slider.config.video import VideoConfig


@dataclass(frozen=True, config=STRICT)
class ReportConfig:
    """Sections of the page in order, and their settings."""

    sections: list[str]
    tracking_commands: list[float]
    video: VideoConfig
