"""The stage ``verification_maps``: what the independent checks found, over the velocities."""

import csv
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.library.reader import GaitLibrary
from slider.reports.figures.maps import VelocityMap
from slider.reports.figures.publication import write_figure
from slider.reports.figures.velocity_maps import draw_maps

TABLE = "verification.csv"
NAME = "verification_maps"
# Column of the table → title and unit.
MAPS: Mapping[str, tuple[str, str]] = {
    "return_map": ("greatest eigenvalue of the return map, open loop", "1"),
    "regulated_steps": ("steps held with foot placement", "steps"),
    "plant_force": ("force left on the base of MuJoCo's robot", "N"),
    "roll_end": ("roll against another integrator, end of step", "rad"),
    "dense_torque": ("peak motor torque between nodes", "share of limit"),
}
CAPTION = """\
One cell per gait. An eigenvalue above 1 means that the gait, left alone in time, drifts away from
its limit cycle, as a walk on line feet does: a controller has to place the feet. The replay holds
at most the configured number of steps. The force is what the plant's inverse dynamics leave on the
base under the stored ground force, at the worst sample: rounding where gaits have the prismatic
leg's dynamics, tens of newtons where they have the virtual knee's. `reports/verification.csv` has
all numbers.
"""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Draw the maps as SVG, PNG and Markdown.

    Raises:
        UserError: the table lacks a gait of the library.
    """
    library = GaitLibrary.load(inputs["library"][0] / "library.zarr")
    table = read_table(inputs["verification"][0] / TABLE)
    maps = [
        VelocityMap(title, _column(library, table, name), unit)
        for name, (title, unit) in MAPS.items()
    ]
    title = "Verification over the commanded velocity"
    write_figure(out / NAME, title, lambda: draw_maps(library, maps), CAPTION)
    job.tracker.log_file(out / f"{NAME}.png")
    return {"maps": len(maps)}


def read_table(path: Path) -> dict[tuple[float, float], dict[str, float]]:
    """Rows by velocity; NaN where a quantity does not apply."""
    with path.open(newline="") as file:
        return {
            (float(row["vx"]), float(row["vy"])): {name: float(row[name] or "nan") for name in MAPS}
            for row in csv.DictReader(file)
        }


def _column(
    library: GaitLibrary, table: Mapping[tuple[float, float], Mapping[str, float]], name: str
) -> np.ndarray:
    values = []
    for vx, vy in library.velocities:
        row = table.get((float(vx), float(vy)))
        if row is None:
            raise UserError(f"{TABLE}: expected the gait ({vx:g}, {vy:g}) m/s, found none")
        values.append(row[name])
    return np.array(values)
