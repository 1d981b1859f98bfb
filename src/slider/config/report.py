"""Typed settings of the page."""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.env import Level, TerrainKind
from slider.config.types import (
    STRICT,
    Count,
    Distinct,
    Even,
    MetresPerSecond,
    Name,
    Positive,
    Seconds,
    Seed,
    Some,
)

Pixels = Even[Annotated[int, Field(ge=32, le=1920)]]
"""H.264 stores colours at half the resolution."""


@dataclass(frozen=True, config=STRICT)
class FilmedTerrain:
    """Videos of the policy on terrain, with onboard state."""

    kinds: Distinct[list[TerrainKind]]
    """one video for each"""
    level: Level
    """of all of them"""
    speed: MetresPerSecond
    """commanded forward velocity"""


@dataclass(frozen=True, config=STRICT)
class VideoConfig:
    """Which videos are made, and how; the section of a single one has no lists of them."""

    renderer: Literal["auto", "egl", "osmesa", "none"]
    """none: a page without videos; auto: the first that works"""
    camera: Literal["side", "front", "both"]
    """where they are filmed from; both: two pictures next to each other"""
    duration: Positive[Seconds]
    """from rest"""
    width: Pixels
    """of a picture, in pixels"""
    height: Pixels
    """of a picture, in pixels"""
    frame_rate: Annotated[Count, Field(le=1000)]
    """frames per second; must divide the control rate"""
    quality: Annotated[int, Field(ge=0, le=51)]
    """constant rate factor of H.264, 0 (lossless, large) to 51"""
    seed: Seed
    """of the start's noise"""
    speeds: Distinct[list[MetresPerSecond]] = field(default_factory=list)
    """one video per controller and speed"""
    terrain: FilmedTerrain | None = None
    """videos on ground that is not flat; null: none"""

    @property
    def cameras(self) -> tuple[str, ...]:
        """From left to right in a picture."""
        return ("side", "front") if self.camera == "both" else (self.camera,)


@dataclass(frozen=True, config=STRICT)
class ReportConfig:
    """The page reports/index.html and the videos in it."""

    sections: Distinct[Some[Name]]
    """of the page, in order"""
    tracking_speeds: Distinct[list[MetresPerSecond]]
    """velocity tracking is drawn for these, where evaluated"""
    video: VideoConfig
