"""Typed settings of the page."""

from pydantic.dataclasses import dataclass

from slider.config.types import STRICT, Distinct, MetresPerSecond, Name, Some
from slider.config.video import VideoConfig


@dataclass(frozen=True, config=STRICT)
class ReportConfig:
    """The page reports/index.html and the videos in it."""

    sections: Distinct[Some[Name]]
    """of the page, in order"""
    tracking_commands: Distinct[list[MetresPerSecond]]
    """velocity tracking is drawn for these, where evaluated"""
    video: VideoConfig
