"""Sections of the page: title, inputs, and where each is written.

A new section is a line here; if no report of the pipeline has its text, also a function in
``slider.reports.page``. Every protocol is a section by its name. This module imports no plotting,
so that planning the jobs does not wait for it.
"""

from typing import NamedTuple

from slider.config.schema import Config
from slider.core.errors import one_of

OPTIONAL = "?"


class PageSection(NamedTuple):
    """Heading of a section, names of its inputs, and the Markdown of these that it shows.

    An input is a target of ``pipeline/targets.py``, such as ``verification``; a group of a
    target's own inputs, such as ``table1.evaluations``; or ``videos``. One that is optional in a
    configuration ends with a question mark. ``documents`` are ``INPUT/FILE``.
    """

    title: str
    needs: tuple[str, ...] = ()
    documents: tuple[str, ...] = ()


def _reported(name: str) -> PageSection:
    """A section of the report of a target."""
    target = name.removesuffix(OPTIONAL)
    return PageSection(target.replace("_", " ").capitalize(), (name,), (f"{target}/{target}.md",))


_TRAININGS = ("standing?", "untuned?", "walking")
SECTIONS = {
    "overview": PageSection("In short", ("table1", "videos?")),
    "table1": PageSection("Table 1", ("table1",), ("table1/table1.md", "table1/gait_quality.md")),
    "tracking": _reported("velocity_tracking?"),
    "videos": PageSection("Videos", ("videos",)),
    "gaits": PageSection(
        "Gait library",
        ("figures",),
        tuple(f"figures/{name}.md" for name in ("velocity_maps", "limit_cycles")),
    ),
    "verification": _reported("verification"),
    "learning": PageSection("Learning curves", _TRAININGS),
    "ablation": _reported("ablation"),
    "gauge": _reported("gauge"),
    "statements": PageSection("The paper, statement by statement"),
    "provenance": PageSection(
        "Provenance",
        ("library.gaits", "library", *_TRAININGS, "table1.evaluations", "table1"),
    ),
}


def page_section(name: str) -> PageSection:
    """A section of the table, or that of a protocol."""
    return SECTIONS.get(name) or _reported(name)


def check_sections(config: Config) -> None:
    """Check that each section of the page is in the table, or a protocol.

    Raises:
        UserError: it is neither; lists all sections.
    """
    for name in config.report.sections:
        one_of("report.sections", name, [*SECTIONS, *config.protocols])
