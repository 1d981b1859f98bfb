"""One gait on one page: from the side, joints, motor torques, ground force, foot height."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.library.measures import foot_heights, motor_torques
from slider.library.reader import GaitLibrary
from slider.reports.figures.gait_tiles import draw_tiles, tile_samples
from slider.reports.figures.style import DARK, MIDDLE, new_figure
from slider.robot.names import (
    JOINTS,
    LEG_JOINTS,
    LEG_MOTORS,
    MOTORS,
    NUM_JOINTS,
    SIDES,
    command_text,
)
from slider.robot.transmission import by_motor

_SHOWN = LEG_JOINTS[:5]
_LINES = {"left": (DARK, "-"), "right": (MIDDLE, "--")}
_HEIGHTS = (1.35, 1.15, 1.15, 1.15)  # of the rows [inch]


def draw(library: GaitLibrary, gait: int) -> Figure:
    """Draw the gait with an index of the library; ``style()`` must be active."""
    figure = new_figure(sum(_HEIGHTS) + 1.4)
    heights = (_HEIGHTS[0], sum(_HEIGHTS[1:]) + 0.6)
    tiles, plots = figure.subfigures(2, 1, squeeze=False, height_ratios=heights)[:, 0]
    figure.suptitle(f"gait at {command_text(library.commands[gait])}", fontsize=9)
    draw_tiles(tiles.subplots(1, len(tile_samples(library))), library, gait)
    panels = plots.subplots(3, 5, sharex=True)
    positions = library.arrays["samples"][gait][:, :NUM_JOINTS]
    for axes, joint in zip(panels[0], _SHOWN, strict=True):
        _both_legs(axes, library, gait, [f"{side}_{joint}" for side in SIDES], JOINTS, positions)
    torques = motor_torques(library, gait)
    for axes, motor in zip(panels[1], LEG_MOTORS, strict=True):
        _both_legs(axes, library, gait, [f"{side}_{motor}" for side in SIDES], MOTORS, torques)
    _label(panels, library)
    _ground(panels[2], library, gait)
    for axes in panels.flat:
        axes.title.set_size(7)
    return figure


def _both_legs(
    axes: Axes,
    library: GaitLibrary,
    gait: int,
    pair: list[str],
    order: tuple[str, ...],
    values: np.ndarray,
) -> None:
    _two_lines(axes, library, gait, [values[:, order.index(name)] for name in pair])


def _two_lines(axes: Axes, library: GaitLibrary, gait: int, columns: list[np.ndarray]) -> None:
    """Left and right over time, in pieces: values jump at the touchdown."""
    time = library.arrays["time"][gait]
    half = len(time) // 2
    for side, values in zip(SIDES, columns, strict=True):
        colour, dash = _LINES[side]
        for piece, label in ((slice(0, half), side), (slice(half, None), None)):
            axes.plot(time[piece], values[piece], dash, color=colour, label=label)
    axes.axvline(time[half], color="black", linewidth=0.5, linestyle=":")


def _label(panels: np.ndarray, library: GaitLibrary) -> None:
    for axes, joint in zip(panels[0], _SHOWN, strict=True):
        axes.set_title(f"{joint.replace('_', ' ')} [{'m' if joint == 'slide' else 'rad'}]")
    drives = by_motor(library.robot.drives)
    for axes, motor, drive in zip(panels[1], LEG_MOTORS, drives, strict=True):
        axes.set_title(f"{motor.replace('_', ' ')} [N m of {drive.torque:g}]")
    panels[0, 0].legend()


def _ground(row: np.ndarray, library: GaitLibrary, gait: int) -> None:
    """Ground force under the stance foot, its line's loads, height and speed."""
    time, wrench = library.arrays["time"][gait], library.arrays["ground_wrench"][gait]
    half = len(time) // 2
    columns = [
        np.where(np.arange(len(time)) < half, wrench[:, 2], np.nan),
        np.where(np.arange(len(time)) < half, np.nan, wrench[:, 2]),
    ]
    _two_lines(row[0], library, gait, columns)
    row[0].set_title("ground force z [N]")
    heights = 100 * foot_heights(library, gait)
    _two_lines(row[1], library, gait, [heights[:, 0], heights[:, 1]])
    row[1].set_title("foot height [cm]")
    samples = library.arrays["samples"][gait]
    speeds = [samples[:, NUM_JOINTS + JOINTS.index(f"{side}_slide")] for side in SIDES]
    _two_lines(row[3], library, gait, speeds)
    row[3].set_title("slide speed [m/s]")
    for axes, column, name in ((row[2], -2, "forward"), (row[4], -1, "leftward")):
        for piece in (slice(0, half), slice(half, None)):
            axes.plot(time[piece], samples[piece, column], color=DARK)
        axes.axvline(time[half], color="black", linewidth=0.5, linestyle=":")
        axes.set_title(f"base {name} [m/s]")
    for axes in row:
        axes.set_xlabel("time [s]")
