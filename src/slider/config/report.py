"""Typed settings of the report, and what each section of the page needs."""

from pydantic.dataclasses import dataclass

from slider.config.types import STRICT, Distinct, MetresPerSecond, Name, Some
from slider.config.video import VideoConfig

PROTOCOL_SECTIONS = ("robust", "sweep", "joystick", "heldout")
"""Sections about protocols beside that of Table 1; each is called as its protocol."""

SECTION_INPUTS: dict[str, tuple[str, ...]] = {
    "table1": ("table1",),
    "tracking": ("table1.evaluations",),
    "videos": ("videos",),
    "gaits": ("library",),
    "verification": ("verification", "verification.gaits"),
    "learning": ("standing", "untuned", "walking"),
    **{name: (name,) for name in PROTOCOL_SECTIONS},
    "ablation": ("ablation",),
    "readings": (),
    "provenance": (
        "library.gaits",
        "library",
        "standing",
        "untuned",
        "walking",
        "table1.evaluations",
        "table1",
    ),
}
"""Section of the page → names of its inputs; the pipeline makes exactly these.

A name is a target of ``pipeline/targets.py``, such as ``verification``; a group of a target's own
inputs, such as ``verification.gaits``; or ``videos``.
"""


@dataclass(frozen=True, config=STRICT)
class ReportConfig:
    """The page reports/index.html and the videos in it."""

    sections: Distinct[Some[Name]]
    """of the page, in order"""
    tracking_commands: Distinct[list[MetresPerSecond]]
    """velocity tracking is drawn for these, where evaluated"""
    video: VideoConfig
