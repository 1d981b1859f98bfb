"""Typed settings of the videos; apart from the page, so that a new section films nothing anew."""

from dataclasses import field

from pydantic.dataclasses import dataclass

from slider.core.config.strict import STRICT

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
