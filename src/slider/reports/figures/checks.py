"""The stages ``verification_maps`` and ``stability_figures``: tables of gaits as pictures."""

from pathlib import Path

import pandas as pd

from slider.core import tables
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.hzd.summary import CSV
from slider.library.reader import STORE, GaitLibrary
from slider.reports.figures import STABILITY
from slider.reports.figures.maps import draw_maps
from slider.reports.figures.style import write_figure
from slider.robot.names import VELOCITY, velocity_text
from slider.verification.quantities import QUANTITIES

TABLE = "verification.csv"
NAME = "verification_maps"
MAPS = (  # what a gait is like, rather than whether its numbers are right
    "plant_force",
    "roll_end",
    "dense_torque",
    "dense_cop",
    "dense_friction",
)
VERIFICATION_CAPTION = """\
One cell per gait. The force is what the plant's inverse dynamics leave on the base under the stored
ground force, at the worst sample: rounding where gaits have the prismatic leg's dynamics, tens of
newtons where they have the virtual knee's. `reports/verification.csv` has all numbers.
"""


def run_verification(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Draw what the independent checks give as maps, SVG and Markdown.

    Raises:
        UserError: the table lacks a gait of the library.
    """
    library = GaitLibrary.load(inputs["library"][0] / STORE).straight
    frame = by_gait(library, inputs["verification"][0] / TABLE)
    maps = [(QUANTITIES[name].title, frame[name].to_numpy(float), unit(name)) for name in MAPS]
    title = "Verification over the commanded velocity"
    write_figure(out / NAME, title, lambda: draw_maps(library, maps), VERIFICATION_CAPTION)
    return {"maps": len(maps)}


def unit(name: str) -> str:
    """Unit of a quantity; nothing for plain numbers."""
    text = QUANTITIES[name].unit
    return "" if text in ("-", "1") else text


def by_gait(library: GaitLibrary, path: Path) -> pd.DataFrame:
    """Rows of a table in the order of the library's gaits; NaN where a quantity does not apply.

    Raises:
        UserError: the table lacks a gait.
    """
    frame = tables.read(path).set_index([*VELOCITY])
    gaits = [tuple(velocity) for velocity in library.velocities.tolist()]
    for velocity in gaits:
        if velocity not in frame.index:
            raise UserError(f"expected a row of the gait {velocity_text(velocity)}, found none")
    return frame.loc[gaits]


_SHOWN = {
    "spectral_radius": ("spectral radius per step, without foot placement", ""),
    "closed_spectral_radius": ("spectral radius per step, with it", ""),
    "gain_lateral": ("displacement per lateral velocity", "s"),
    "decoupling": ("least singular value of the decoupling matrix", "rad/s², m/s²"),
}
MAPS_CAPTION = """\
One cell per gait. The return map is that of the rooted robot under its virtual constraints; its
spectral radius is per step, the root of that of a walk's two. Above 1 the walk leaves its limit
cycle. The foot placement is the linear-quadratic regulator's at the start of a step.
`stability.csv` has all numbers.
"""


def run_stability(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Draw spectral radii and what goes with them as SVG and Markdown."""
    library = GaitLibrary.load(inputs["library"][0] / STORE)
    frame = by_gait(library, inputs["stability"][0] / CSV)
    maps = [(title, frame[name].to_numpy(float), unit) for name, (title, unit) in _SHOWN.items()]
    title = "Stability over the commanded velocity"
    write_figure(out / STABILITY, title, lambda: draw_maps(library, maps), MAPS_CAPTION)
    return {"gaits": len(frame)}
