"""Typed settings of the videos; apart from the page, so that a new section films nothing anew."""

from dataclasses import field
from typing import Literal

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT

RENDERERS = ("auto", "egl", "osmesa", "none")


@dataclass(frozen=True, config=STRICT)
class VideoConfig:
    """Which videos are made, and how; ``commands`` is not in the section of a single one.

    ``camera`` is where they are filmed from; ``both`` shows the two pictures next to each other.
    """

    renderer: str
    camera: Literal["side", "front", "both"]
    duration: float
    width: int
    height: int
    frame_rate: int
    quality: int
    seed: int
    commands: list[float] = field(default_factory=list)

    @property
    def cameras(self) -> tuple[str, ...]:
        """From left to right in a picture."""
        return ("side", "front") if self.camera == "both" else (self.camera,)
