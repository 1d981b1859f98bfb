"""Typed settings of the report and its videos, and what each section of the page needs."""

from dataclasses import field

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
    """Which videos are made, and how; ``commands`` is not in the section of a single one."""

    renderer: str
    duration: float
    width: int
    height: int
    frame_rate: int
    quality: int
    seed: int
    commands: list[float] = field(default_factory=list)


@dataclass(frozen=True, config=STRICT)
class ReportConfig:
    """Sections of the page in order, and their settings."""

    sections: list[str]
    tracking_commands: list[float]
    video: VideoConfig
