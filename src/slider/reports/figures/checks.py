"""The stages ``verification_maps`` and ``stability_figures``: tables of gaits as pictures."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.hzd.summary import CSV
from slider.library.reader import STORE, GaitLibrary
from slider.reports import rows
from slider.reports.figures import STABILITY
from slider.reports.figures.maps import draw_maps
from slider.reports.figures.style import COLOURS, DARK, EMPTY, MIDDLE, new_figure, write_figure
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
    table = rows_by_command(inputs["verification"][0] / TABLE)
    maps = [
        (QUANTITIES[name].meaning, gait_values(library, table, name), unit(name)) for name in MAPS
    ]
    title = "Verification over the commanded velocity"
    write_figure(out / NAME, title, lambda: draw_maps(library, maps), VERIFICATION_CAPTION)
    return {"maps": len(maps)}


def unit(name: str) -> str:
    """Unit of a quantity; nothing for plain numbers."""
    text = QUANTITIES[name].unit
    return "" if text in ("-", "1") else text


def rows_by_command(path: Path) -> dict[tuple[float, ...], rows.Row]:
    """Rows by command; NaN where a quantity does not apply."""
    return {tuple(row[name] for name in VELOCITY): row for row in rows.read(path)}


def gait_values(
    library: GaitLibrary, table: Mapping[tuple[float, ...], rows.Row], name: str
) -> np.ndarray:
    """A quantity of each gait (G,), in the order of the library.

    Raises:
        UserError: the table lacks a gait.
    """
    for command in library.velocities.tolist():
        if tuple(command) not in table:
            raise UserError(f"expected a row of the gait {velocity_text(command)}, found none")
    return np.array([table[tuple(command)][name] for command in library.velocities.tolist()], float)


_SHOWN = {
    "spectral_radius": ("spectral radius per step, without foot placement", ""),
    "closed_spectral_radius": ("spectral radius per step, with it", ""),
    "gain_lateral": ("displacement per lateral velocity", "s"),
    "decoupling": ("least singular value of the decoupling matrix", "rad/s², m/s²"),
}
_PLACEMENT = ("without", "with")
Arrays = Mapping[str, np.ndarray]
"""Result of the stage ``basin`` for a gait, by the names of its files."""
MAPS_CAPTION = """\
One cell per gait. The return map is that of the rooted robot under its virtual constraints, all of
the state; its spectral radius is per step, the root of that of a walk's two. Above 1 the walk
leaves its limit cycle. The foot placement is the linear-quadratic regulator's at the start of a
step. `stability.csv` has all numbers.
"""
BASINS_CAPTION = """\
Steps after which the roll of the stance foot and its rate are back at the limit cycle, over their
perturbation just after an impact; grey: never. Above without, below with foot placement. The model
has no torque limits and its feet do not slip.
"""
PORTRAITS_CAPTION = """\
Roll of the stance foot against its rate, executed: a walk that starts with a perturbed roll rate
(circle), and the limit cycle (dark). Impacts are jumps. Without foot placement the walk leaves the
cycle, with it it returns.
"""


def run_stability(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Draw spectral radii, basins and perturbed walks as SVG and Markdown."""
    library = GaitLibrary.load(inputs["library"][0] / STORE)
    table = rows_by_command(inputs["stability"][0] / CSV)
    maps = [
        (title, gait_values(library, table, name), unit) for name, (title, unit) in _SHOWN.items()
    ]
    basins = [
        {path.stem: np.load(path) for path in folder.glob("*.npy")}
        for folder in inputs.get("basins", ())
    ]
    drawings = (
        ("Stability over the commanded velocity", lambda: draw_maps(library, maps), MAPS_CAPTION),
        ("Basins of attraction", lambda: draw_basins(basins), BASINS_CAPTION),
        ("Walks that converge", lambda: draw_portraits(basins), PORTRAITS_CAPTION),
    )
    for name, (title, draw, caption) in zip(STABILITY, drawings, strict=True):
        write_figure(out / name, title, draw, caption)
    return {"gaits": len(table), "basins": len(basins)}


def draw_basins(basins: Sequence[Arrays]) -> Figure:
    """Of each gait the steps to the limit cycle over the perturbation; −1: not back."""
    figure, panels = _panels(basins, sharex=True, sharey=True)
    most = max([2, *(int(basin[name].max()) for basin in basins for name in _PLACEMENT)])
    for axes, basin, name in panels:
        axes.set_facecolor(EMPTY)
        shown = np.ma.masked_less(basin[name], 0).T
        look = {"cmap": f"{COLOURS}_r", "vmin": 1, "vmax": most}
        mesh = axes.pcolormesh(basin["roll"], basin["roll_rate"], shown, **look)
        axes.plot(0, 0, "+", color=MIDDLE)
        axes.grid(visible=False)
    if panels:
        figure.colorbar(mesh, ax=figure.axes, pad=0.01, aspect=40).set_label("steps")
    return figure


def draw_portraits(basins: Sequence[Arrays]) -> Figure:
    """Of each gait its limit cycle and a walk from a perturbed roll rate."""
    figure, panels = _panels(basins, sharex="col", sharey="col")
    for axes, basin, name in panels:
        walked, cycle = basin[f"walk_{name}"], basin["cycle"]
        axes.plot(*walked.T, color=MIDDLE, linewidth=0.8)
        axes.plot(*walked[:1].T, "o", color=MIDDLE, markersize=3)
        axes.plot(*np.concatenate([cycle, cycle[:1]]).T, color=DARK, linewidth=1.4)
        wide = 2.5 * np.ptp(cycle, axis=0)
        middle = (cycle.max(axis=0) + cycle.min(axis=0)) / 2
        axes.set_xlim(middle[0] - wide[0], middle[0] + wide[0])
        axes.set_ylim(middle[1] - wide[1], middle[1] + wide[1])
    return figure


def _panels(
    basins: Sequence[Arrays], **shared: Any
) -> tuple[Figure, list[tuple[Axes, Arrays, str]]]:
    """A column per gait: without foot placement above, with it below."""
    figure, panels = new_figure(3.6), []
    if basins:
        grid = figure.subplots(2, len(basins), squeeze=False, **shared)
        for column, basin in zip(grid.T, basins, strict=True):
            vx, vy, _ = basin["velocity"]
            title = f"{vx:g} m/s" if vy == 0.0 else f"({vx:g}, {vy:g}) m/s"
            for axes, name in zip(column, _PLACEMENT, strict=True):
                axes.set_title(f"{title}, {name}", loc="left")
                axes.set(xlabel="roll [rad]", ylabel="roll rate [rad/s]")
                axes.label_outer()
                panels.append((axes, basin, name))
    return figure, panels
