"""The stage ``figures``: pictures of the gait library, each with a caption beside it."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from slider.core import tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.library.reader import STORE, GaitLibrary
from slider.reports.figures import gaits, mapping, maps, zero_dynamics
from slider.reports.figures.style import write_pictures

Caption = str | Callable[[GaitLibrary], str]
DRAWINGS: dict[str, tuple[str, Callable[[GaitLibrary], Figure], Caption]] = {
    "mapping": ("Mapping between virtual knee and slide", mapping.draw, mapping.caption),
    "zero_dynamics": (
        "Transformation of the zero dynamics",
        zero_dynamics.draw,
        zero_dynamics.caption,
    ),
    "limit_cycles": ("Limit cycles", gaits.draw_cycles, gaits.CYCLES_CAPTION),
    "gait_tiles": ("Gaits from the side", gaits.draw_walks, gaits.TILES_CAPTION),
    "velocity_maps": (
        "Gaits over the commanded velocity",
        maps.draw_velocity_maps,
        maps.MAPS_CAPTION,
    ),
}
"""Name of the file → title, figure and caption of a library."""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Draw every figure of ``DRAWINGS`` as SVG, with its caption as Markdown."""
    library = GaitLibrary.load(inputs["library"][0] / STORE).straight
    for name, (title, draw, caption) in DRAWINGS.items():
        job.progress(name)
        write_pictures(out / name, partial(draw, library))
        parts = [f"# {title}", f"![{title}]({name}.svg)"]
        parts.append(caption if isinstance(caption, str) else caption(library))
        (out / f"{name}.md").write_text(tables.markdown(parts), encoding="utf-8")
    return {"figures": len(DRAWINGS)}
