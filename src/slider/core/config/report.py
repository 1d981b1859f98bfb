"""Typed settings of the report and its videos, and what each section of the page needs."""

from pydantic.dataclasses import dataclass

from slider.core.config.strict import STRICT

SECTION_INPUTS: dict[str, tuple[str, ...]] = {
    "table1": ("table1",),
    "tracking": ("evaluations",),
    "videos": ("videos",),
    "gaits": ("library",),
    "learning": ("standing", "walking"),
    "readings": (),
    "provenance": ("gaits", "library", "standing", "walking", "evaluations", "table1"),
}
"""Section of the page → names of its inputs; the pipeline makes exactly these."""

RENDERERS = ("auto", "egl", "osmesa", "none")


@dataclass(frozen=True, config=STRICT)
class VideoConfig:
    """Which videos are made, and how."""

    renderer: str
    commands: list[float]
    duration: float
    width: int
    height: int
    frame_rate: int
    quality: int
    seed: int


@dataclass(frozen=True, config=STRICT)
class ReportConfig:
    """Sections of the page in order, and their settings."""

    sections: list[str]
    tracking_commands: list[float]
    video: VideoConfig
