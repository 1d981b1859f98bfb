"""The stage ``figures``: pictures of the gait library, each with a caption beside it."""

from functools import partial
from pathlib import Path

from slider.core import tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.library.reader import STORE, GaitLibrary
from slider.reports.figures import cycles, mapping, maps, zero_dynamics
from slider.reports.figures.style import write_pictures

DRAWINGS = {
    "mapping": ("Mapping between virtual knee and slide", mapping),
    "zero_dynamics": ("Transformation of the zero dynamics", zero_dynamics),
    "limit_cycles": ("Limit cycles", cycles),
    "velocity_maps": ("Gaits over the commanded velocity", maps),
}
"""Name of the file → title, and module with ``draw`` and ``caption`` of a library."""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Draw every figure of ``DRAWINGS`` as SVG, with its caption as Markdown."""
    library = GaitLibrary.load(inputs["library"][0] / STORE).straight
    for name, (title, module) in DRAWINGS.items():
        job.progress(name)
        write_pictures(out / name, partial(module.draw, library))
        parts = [f"# {title}", f"![{title}]({name}.svg)", module.caption(library)]
        (out / f"{name}.md").write_text(tables.markdown(parts), encoding="utf-8")
    return {"figures": len(DRAWINGS)}
