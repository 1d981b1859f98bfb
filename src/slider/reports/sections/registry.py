"""Sections of the page: what each needs, and what makes its blocks.

A new one is a function here. It imports what draws it when it is called: laying out the jobs reads
the declarations alone.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from slider.config.checks import one_of
from slider.config.schema import Config

if TYPE_CHECKING:  # the declarations alone are read more often than a page is drawn
    from slider.reports.sections.sources import Sources

OPTIONAL = "?"


Blocks = Iterable[Any]
Draw = Callable[["Sources"], Blocks]


@dataclass(frozen=True)
class PageSection:
    """A section as it is declared.

    Attributes:
        title: its heading.
        needs: names of its inputs: a target of ``pipeline/targets.py``, such as ``verification``;
            a group of a target's own inputs, such as ``table1.evaluations``; or ``videos``. With a
            question mark at its end one that a configuration may be without.
        blocks: see ``templates/blocks.html``.
    """

    title: str
    needs: tuple[str, ...]
    blocks: Draw


SECTIONS: dict[str, PageSection] = {}


def section(title: str, *needs: str) -> Callable[[Draw], Draw]:
    """Declare the section that is called as the function."""

    def declare(blocks: Draw) -> Draw:
        SECTIONS[blocks.__name__] = PageSection(title, needs, blocks)
        return blocks

    return declare


@section("Table 1", "table1.evaluations", "table1.library?")
def table1(sources: "Sources") -> Blocks:
    """Ours, the baselines' and the paper's side by side, and how it walks."""
    from slider.reports.table1 import blocks

    library = sources.inputs.get("table1.library", ())
    return blocks(sources.evaluations("table1"), library, sources.configuration["evaluation"])


@section("Velocity tracking", "table1.evaluations")
def tracking(sources: "Sources") -> Blocks:
    """Forward velocity over time, as in the paper's figure."""
    from slider.reports.sections.tracking import blocks

    return blocks(sources)


@section("Videos", "videos")
def videos(sources: "Sources") -> Blocks:
    """All videos, in the page itself."""
    from slider.reports.sections.videos import blocks

    return blocks(sources)


@section("Gait library", "library")
def gaits(sources: "Sources") -> Blocks:
    """Maps over the commanded velocity, and the limit cycle of each gait."""
    from slider.reports.sections.gaits import blocks

    return blocks(sources)


@section("Verification", "verification", "verification.gaits", "verification_maps")
def verification(sources: "Sources") -> Blocks:
    """What the independent checks of the gaits found."""
    from slider.reports.sections.verification import blocks

    return blocks(sources)


@section("Learning curves", "standing?", "untuned?", "walking")
def learning(sources: "Sources") -> Blocks:
    """The periodic checks and the terms of the reward of each training."""
    from slider.reports.sections.learning import blocks

    return blocks(sources)


@section("Ablation", "ablation")
def ablation(sources: "Sources") -> Blocks:
    """What each choice of the method is worth."""
    from slider.reports.study import blocks

    return blocks("ablation", sources.inputs["ablation"][0])


@section("The paper, statement by statement")
def readings(sources: "Sources") -> Blocks:
    """What is here of the paper, and the value that each choice has in this run."""
    from slider.reports.sections.readings import blocks

    return blocks(sources)


@section(
    "Provenance",
    "library.gaits",
    "library",
    "standing?",
    "untuned?",
    "walking",
    "table1.evaluations",
    "table1",
)
def provenance(sources: "Sources") -> Blocks:
    """Commit, configuration, recipes, versions, seeds, machine, times."""
    from slider.reports.sections.provenance import blocks

    return blocks(sources)


def _protocol(name: str, about: str, sources: "Sources") -> Blocks:
    """The figure of a protocol's report, and its tables; its settings tell the kind."""
    from slider.config.convert import from_dict
    from slider.config.evaluation import EvaluationConfig
    from slider.reports.protocols import cases, segments, speeds
    from slider.reports.table import Text

    protocol = from_dict(EvaluationConfig, sources.configuration["protocols"][name])
    kinds = {"": speeds, "segments": segments, "cases": cases}
    kind = kinds[protocol.profile.rows if protocol.profile else ""]
    rows = kind.read_rows(sources.evaluations(name), protocol)
    yield Text(f"{about} Seeds {protocol.seed} to {protocol.seed + protocol.trials - 1}.")
    yield from kind.blocks(name, sources.file(name, f"{name}.svg"), rows, protocol)


_PROTOCOLS = (
    (
        "robust",
        "Disturbed robots",
        "Noise, delay, pushes, and robots and ground that differ from those of the training.",
    ),
    ("sweep", "Sweep of the commanded speed", "Every command from standing to the fastest."),
    ("joystick", "Changing commands", "Commands as from a joystick, changing on the way."),
    (
        "heldout",
        "Held-out commands",
        "Speeds between those that checkpoints are chosen by, a minute of each, stops, sideways.",
    ),
)
PROTOCOLS = tuple(name for name, _, _ in _PROTOCOLS)
"""Sections about a protocol each; a configuration may be without it."""

for _name, _title, _about in _PROTOCOLS:
    _needs = (_name, f"{_name}.evaluations")
    SECTIONS[_name] = PageSection(_title, _needs, partial(_protocol, _name, _about))


def check_sections(config: Config) -> None:
    """Each section of the page exists, and so does the protocol that it is about.

    Raises:
        UserError: names those that there are.
    """
    known = [name for name in SECTIONS if name not in PROTOCOLS or name in config.protocols]
    for name in config.report.sections:
        one_of("report.sections", name, known)
