"""Sections of the page: title and inputs of each.

A new section is a line here and the function of its name in ``slider.reports.contents``. This
module draws nothing, so that the jobs are laid out without what draws.
"""

from typing import NamedTuple

from slider.config.schema import Config
from slider.core.errors import one_of

OPTIONAL = "?"
PROTOCOLS = ("robust", "sweep", "joystick", "heldout")
"""Sections about a protocol each; a configuration may be without it."""


class PageSection(NamedTuple):
    """Heading of a section and names of its inputs.

    One is a target of ``pipeline/targets.py``, such as ``verification``; a group of a target's own
    inputs, such as ``table1.evaluations``; or ``videos``. One that a configuration may be without
    has a question mark at its end.
    """

    title: str
    needs: tuple[str, ...] = ()


_TRAININGS = ("standing?", "untuned?", "walking")
SECTIONS = {
    "overview": PageSection("In short", ("table1.evaluations", "videos?")),
    "table1": PageSection("Table 1", ("table1.evaluations", "table1.library?")),
    "tracking": PageSection("Velocity tracking", ("table1.evaluations",)),
    "videos": PageSection("Videos", ("videos",)),
    "gaits": PageSection("Gait library", ("library", "figures")),
    "verification": PageSection(
        "Verification", ("verification", "verification.gaits", "verification_maps")
    ),
    "learning": PageSection("Learning curves", _TRAININGS),
    "ablation": PageSection("Ablation", ("ablation",)),
    "gauge": PageSection("Gauge", ("gauge",)),
    "readings": PageSection("The paper, statement by statement"),
    "provenance": PageSection(
        "Provenance",
        ("library.gaits", "library", *_TRAININGS, "table1.evaluations", "table1"),
    ),
    "robust": PageSection("Disturbed robots", ("robust", "robust.evaluations")),
    "sweep": PageSection("Sweep of the commanded speed", ("sweep", "sweep.evaluations")),
    "joystick": PageSection("Changing commands", ("joystick", "joystick.evaluations")),
    "heldout": PageSection("Held-out commands", ("heldout", "heldout.evaluations")),
}


def check_sections(config: Config) -> None:
    """Each section of the page exists, and so does the protocol that it is about.

    Raises:
        UserError: names those that there are.
    """
    names = [name for name in SECTIONS if name not in PROTOCOLS or name in config.protocols]
    for name in config.report.sections:
        one_of("report.sections", name, names)
