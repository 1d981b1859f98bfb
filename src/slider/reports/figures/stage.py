"""The stage ``figures``: pictures of the gait library, each with a caption beside it."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from slider.core.job import Inputs, Job, Section, Summary
from slider.library.reader import STORE, GaitLibrary
from slider.reports.figures import (
    NAMES,
    capstan,
    convergence,
    gait_tiles,
    limit_cycles,
    mapping,
    maps,
    smoothness,
    zero_dynamics,
)
from slider.reports.figures.style import write_figure


class Drawing(NamedTuple):
    """A figure of a library and the Markdown that explains it."""

    title: str
    draw: Callable[[GaitLibrary], Figure]
    caption: str | Callable[[GaitLibrary], str]


DRAWINGS = {
    "capstan": Drawing("Differential capstan drive", capstan.draw, capstan.caption),
    "mapping": Drawing(
        "Mapping between virtual-knee leg and prismatic leg", mapping.draw, mapping.caption
    ),
    "zero_dynamics": Drawing(
        "Transformation of the zero dynamics", zero_dynamics.draw, zero_dynamics.caption
    ),
    "limit_cycles": Drawing("Limit cycles", limit_cycles.draw, limit_cycles.CAPTION),
    "gait_tiles": Drawing("Gaits from the side", gait_tiles.draw, gait_tiles.CAPTION),
    "velocity_maps": Drawing("Gaits over the commanded velocity", maps.draw, maps.CAPTION),
    "convergence": Drawing("Convergence", convergence.draw, convergence.caption),
    "smoothness": Drawing("Smoothness of the library", smoothness.draw, smoothness.caption),
}


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Draw every figure of ``slider.reports.figures.NAMES`` as SVG, PNG and Markdown."""
    library = GaitLibrary.load(inputs["library"][0] / STORE).straight
    for name in NAMES:
        title, draw, caption = DRAWINGS[name]
        job.progress(name)
        text = caption if isinstance(caption, str) else caption(library)
        write_figure(out / name, title, lambda draw=draw: draw(library), text)
        job.tracker.log_file(out / f"{name}.png")
    return {"figures": len(NAMES)}
