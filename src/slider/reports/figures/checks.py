"""The stages ``verification_maps`` and ``stability_figures``: tables of gaits as pictures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.hzd.summary import CSV
from slider.library.reader import STORE, GaitLibrary
from slider.reports import rows
from slider.reports.figures import STABILITY
from slider.reports.figures.maps import VelocityMap, draw_maps
from slider.reports.figures.style import COLOURS, DARK, EMPTY, MIDDLE, new_figure, write_figure
from slider.robot.names import VELOCITY, velocity_text
from slider.verification.quantities import QUANTITIES

TABLE = "verification.csv"
NAME = "verification_maps"
MAPS = (  # what a gait is like, rather than whether its numbers are right
    "regulated_steps",
    "plant_force",
    "roll_end",
    "dense_torque",
    "dense_cop",
    "dense_friction",
)
VERIFICATION_CAPTION = """\
One cell per gait. The replay holds at most the configured number of steps. The force is what the
plant's inverse dynamics leave on the base under the stored ground force, at the worst sample:
rounding where gaits have the prismatic leg's dynamics, tens of newtons where they have the virtual
knee's. `reports/verification.csv` has all numbers.
"""


def run_verification(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Draw what the independent checks give as maps, SVG and Markdown.

    Raises:
        UserError: the table lacks a gait of the library.
    """
    library = GaitLibrary.load(inputs["library"][0] / STORE).straight
    table = rows_by_command(inputs["verification"][0] / TABLE)
    maps = [
        VelocityMap(QUANTITIES[name].meaning, gait_values(library, table, name), unit(name))
        for name in MAPS
    ]
    title = "Verification over the commanded velocity"
    write_figure(out / NAME, title, lambda: draw_maps(library, maps), VERIFICATION_CAPTION)
    job.tracker.log_file(out / f"{NAME}.svg")
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
    "spectral_radius": "spectral radius per step, without foot placement",
    "closed_spectral_radius": "spectral radius per step, with it",
    "gain_lateral": "displacement per lateral velocity",
    "decoupling": "least singular value of the decoupling matrix",
}
_UNITS = {"gain_lateral": "s", "decoupling": "rad/s², m/s²"}
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


@dataclass(frozen=True)
class Basin:
    """Result of the stage ``basin`` for a gait.

    Attributes:
        title: its velocity.
        roll, roll_rate: perturbations (R,), (Q,) [rad], [rad/s].
        steps: without and with foot placement (2, R, Q); −1: not back.
        walks: roll and roll rate (N, 2) of a perturbed walk without and with it.
        cycle: of the limit cycle (2 S, 2).
    """

    title: str
    roll: np.ndarray
    roll_rate: np.ndarray
    steps: np.ndarray
    walks: tuple[np.ndarray, np.ndarray]
    cycle: np.ndarray

    @classmethod
    def load(cls, folder: Path) -> "Basin":
        """Read the arrays that the stage wrote."""
        arrays = {path.stem: np.load(path) for path in folder.glob("*.npy")}
        vx, vy, _ = arrays["velocity"]
        return cls(
            f"{vx:g} m/s" if vy == 0.0 else f"({vx:g}, {vy:g}) m/s",
            arrays["roll"],
            arrays["roll_rate"],
            np.stack([arrays["without"], arrays["with"]]),
            (arrays["walk_without"], arrays["walk_with"]),
            arrays["cycle"],
        )


def run_stability(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Draw spectral radii, basins and perturbed walks as SVG and Markdown."""
    library = GaitLibrary.load(inputs["library"][0] / STORE)
    table = rows_by_command(inputs["stability"][0] / CSV)
    maps = [
        VelocityMap(title, gait_values(library, table, name), _UNITS.get(name, ""))
        for name, title in _SHOWN.items()
    ]
    basins = [Basin.load(folder) for folder in inputs.get("basins", ())]
    drawings = (
        ("Stability over the commanded velocity", lambda: draw_maps(library, maps), MAPS_CAPTION),
        ("Basins of attraction", lambda: draw_basins(basins), BASINS_CAPTION),
        ("Walks that converge", lambda: draw_portraits(basins), PORTRAITS_CAPTION),
    )
    for name, (title, draw, caption) in zip(STABILITY, drawings, strict=True):
        write_figure(out / name, title, draw, caption)
        job.tracker.log_file(out / f"{name}.svg")
    return {"gaits": len(table), "basins": len(basins)}


def draw_basins(basins: Sequence[Basin]) -> Figure:
    """A column per gait: without foot placement above, with it below."""
    figure = new_figure(3.6)
    if not basins:
        return figure
    panels = figure.subplots(2, len(basins), sharex=True, sharey=True, squeeze=False)
    most = max(2, *(int(basin.steps.max()) for basin in basins))
    mesh = None
    for column, basin in zip(panels.T, basins, strict=True):
        for axes, steps, name in zip(column, basin.steps, ("without", "with"), strict=True):
            shown = np.ma.masked_less(steps, 0)
            axes.set_facecolor(EMPTY)
            mesh = axes.pcolormesh(
                basin.roll, basin.roll_rate, shown.T, cmap=f"{COLOURS}_r", vmin=1, vmax=most
            )
            axes.plot(0, 0, "+", color=MIDDLE)
            axes.grid(visible=False)
            axes.set_title(f"{basin.title}, {name}", loc="left")
            axes.set(xlabel="roll [rad]", ylabel="roll rate [rad/s]")
            axes.label_outer()
    assert mesh is not None
    figure.colorbar(mesh, ax=panels, pad=0.01, aspect=40).set_label("steps")
    return figure


def draw_portraits(basins: Sequence[Basin]) -> Figure:
    """A column per gait: without foot placement above, with it below."""
    figure = new_figure(3.6)
    if not basins:
        return figure
    panels = figure.subplots(2, len(basins), sharex="col", sharey="col", squeeze=False)
    for column, basin in zip(panels.T, basins, strict=True):
        for axes, walked, name in zip(column, basin.walks, ("without", "with"), strict=True):
            _portrait(axes, basin.cycle, walked)
            axes.set_title(f"{basin.title}, {name}", loc="left")
            axes.set(xlabel="roll [rad]", ylabel="roll rate [rad/s]")
            axes.label_outer()
    return figure


def _portrait(axes: Axes, cycle: np.ndarray, walked: np.ndarray) -> None:
    axes.plot(*walked.T, color=MIDDLE, linewidth=0.8)
    axes.plot(*walked[:1].T, "o", color=MIDDLE, markersize=3)
    closed = np.concatenate([cycle, cycle[:1]])
    axes.plot(*closed.T, color=DARK, linewidth=1.4)
    wide = 2.5 * np.ptp(cycle, axis=0)
    middle = (cycle.max(axis=0) + cycle.min(axis=0)) / 2
    axes.set_xlim(middle[0] - wide[0], middle[0] + wide[0])
    axes.set_ylim(middle[1] - wide[1], middle[1] + wide[1])
