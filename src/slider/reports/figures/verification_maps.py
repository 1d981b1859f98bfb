"""The stage ``verification_maps``: what the independent checks found, over the velocities."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.library.reader import STORE, GaitLibrary
from slider.reports import rows
from slider.reports.figures.maps import VelocityMap, draw_maps
from slider.reports.figures.style import write_figure
from slider.robot.names import COMMAND, command_text
from slider.verification.quantities import QUANTITIES

TABLE = "verification.csv"
NAME = "verification_maps"
MAPS = (  # what a gait is like, rather than whether its numbers are right
    "return_map",
    "regulated_steps",
    "plant_force",
    "roll_end",
    "dense_torque",
    "dense_cop",
    "dense_friction",
)
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
    library = GaitLibrary.load(inputs["library"][0] / STORE).straight
    table = read_table(inputs["verification"][0] / TABLE)
    maps = [
        VelocityMap(QUANTITIES[name].meaning, gait_values(library, table, name), unit(name))
        for name in MAPS
    ]
    title = "Verification over the commanded velocity"
    write_figure(out / NAME, title, lambda: draw_maps(library, maps), CAPTION)
    job.tracker.log_file(out / f"{NAME}.png")
    return {"maps": len(maps)}


def unit(name: str) -> str:
    """Unit of a quantity; nothing for plain numbers."""
    found = QUANTITIES[name].unit
    return "" if found in ("-", "1") else found


def read_table(path: Path) -> dict[tuple[float, ...], rows.Row]:
    """Rows by command; NaN where a quantity does not apply."""
    return {tuple(row[name] for name in COMMAND): row for row in rows.read(path)}


def gait_values(
    library: GaitLibrary, table: Mapping[tuple[float, ...], rows.Row], name: str
) -> np.ndarray:
    """A quantity of each gait (G,), in the order of the library.

    Raises:
        UserError: the table lacks a gait.
    """
    values = []
    for command in library.commands.tolist():
        row = table.get(tuple(command))
        if row is None:
            raise UserError(f"{TABLE}: expected the gait {command_text(command)}, found none")
        values.append(row[name])
    return np.array(values)
