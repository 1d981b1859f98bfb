"""Sections of the page. A new one is a function here and its inputs in ``SECTION_INPUTS``."""

from collections.abc import Callable
from functools import partial

from slider.config.report import PROTOCOL_SECTIONS
from slider.reports.page import Section
from slider.reports.sections import (
    ablation,
    gaits,
    learning,
    protocols,
    provenance,
    readings,
    table1,
    tracking,
    verification,
    videos,
)
from slider.reports.sections.sources import Sources

SECTIONS: dict[str, Callable[[Sources], Section]] = {
    "table1": table1.section,
    "tracking": tracking.section,
    "videos": videos.section,
    "gaits": gaits.section,
    "verification": verification.section,
    "learning": learning.section,
    **{name: partial(protocols.section, name) for name in PROTOCOL_SECTIONS},
    "ablation": ablation.section,
    "readings": readings.section,
    "provenance": provenance.section,
}
