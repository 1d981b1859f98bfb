"""Typed settings of the page."""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config import types as t
from slider.config.env import Level, TerrainKind

Pixels = t.Even[Annotated[int, Field(ge=32, le=1920)]]
"""H.264 stores colours at half the resolution."""


@dataclass(frozen=True, config=t.STRICT)
class FilmedTerrain:
    """Videos of the policy on terrain, with onboard state."""

    kinds: t.Distinct[list[TerrainKind]]
    """one video for each"""
    level: Level
    """of all of them"""
    speed: t.MetresPerSecond
    """commanded forward velocity"""


@dataclass(frozen=True, config=t.STRICT)
class VideoConfig:
    """Which videos are made, and how; the section of a single one has no lists of them."""

    renderer: Literal["auto", "egl", "osmesa", "none"]
    """none: a page without videos; auto: the first that works"""
    camera: Literal["side", "front", "both"]
    """where they are filmed from; both: two pictures next to each other"""
    duration: t.Positive[t.Seconds]
    """from rest"""
    width: Pixels
    """of a picture, in pixels"""
    height: Pixels
    """of a picture, in pixels"""
    frame_rate: Annotated[t.Count, Field(le=1000)]
    """frames per second; must divide the control rate"""
    quality: Annotated[int, Field(ge=0, le=51)]
    """constant rate factor of H.264, 0 (lossless, large) to 51"""
    seed: t.Seed
    """of the start's noise"""
    speeds: t.Distinct[list[t.MetresPerSecond]] = field(default_factory=list)
    """one video per controller and speed"""
    terrain: FilmedTerrain | None = None
    """videos on ground that is not flat; null: none"""

    @property
    def cameras(self) -> tuple[str, ...]:
        """From left to right in a picture."""
        return ("side", "front") if self.camera == "both" else (self.camera,)


@dataclass(frozen=True, config=t.STRICT)
class ReportConfig:
    """The page reports/index.html and the videos in it."""

    sections: t.Distinct[t.Some[t.Name]]
    """of the page, in order"""
    tracking_speeds: t.Distinct[list[t.MetresPerSecond]]
    """velocity tracking is drawn for these, where evaluated"""
    video: VideoConfig
