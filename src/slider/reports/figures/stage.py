"""The stage ``figures``: pictures of the gait library, each with a caption beside it."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from slider.core.job import Inputs, Job, Section, Summary
from slider.library.reader import STORE, GaitLibrary
from slider.reports.figures import (
    NAMES,
    convergence,
    gait_tiles,
    knee_map_error,
    limit_cycles,
    maps,
    smoothness,
)
from slider.reports.figures.style import write_figure


class Drawing(NamedTuple):
    """A figure of a library and the Markdown that explains it."""

    title: str
    draw: Callable[[GaitLibrary], Figure]
    caption: str | Callable[[GaitLibrary], str]


DRAWINGS = {
    "limit_cycles": Drawing("Limit cycles", limit_cycles.draw, limit_cycles.CAPTION),
    "gait_tiles": Drawing("Gaits from the side", gait_tiles.draw, gait_tiles.CAPTION),
    "velocity_maps": Drawing("Gaits over the commanded velocity", maps.draw, maps.CAPTION),
    "convergence": Drawing("Convergence", convergence.draw, convergence.caption),
    "knee_map_error": Drawing(
        "Equation 1 as printed, against the exact map", knee_map_error.draw, knee_map_error.caption
    ),
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
