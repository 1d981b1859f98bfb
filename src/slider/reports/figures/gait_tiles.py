"""The robot over one walk, from the side, at several forward velocities."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.library.reader import GaitLibrary
from slider.reports.figures.robot_drawing import Posture, draw_ground, draw_posture, postures
from slider.reports.figures.speeds import forward_gaits
from slider.reports.figures.style import new_figure

CAPTION = """\
The prismatic robot (after eq. 1) from its right side over one walk, at several forward velocities;
each tile moves along with the base, and the marks on the ground, 0.1 m apart, stand still. Light:
left leg; dark: right leg, the upper foot at its top; filled: the foot that stands. The fourth and
the fifth tile of a row are the two sides of a touchdown: the same posture, the other stance foot.
"""

_ROWS = 5
_HALF_WIDTH, _TOP = 0.52, 1.24  # of a tile [m]


def draw(library: GaitLibrary) -> Figure:
    """One row per velocity, time goes to the right."""
    chosen = forward_gaits(library, _ROWS)
    columns = tile_samples(library)
    figure = new_figure(1.2 * len(chosen) + 0.1)
    panels = figure.subplots(len(chosen), len(columns), squeeze=False)
    for row, index in zip(panels, chosen, strict=True):
        draw_tiles(row, library, int(index))
        row[0].set_ylabel(f"{library.velocities[index, 0]:.2f} m/s")
    return figure


def caption(library: GaitLibrary) -> str:
    """What a tile is."""
    return CAPTION


def tile_samples(library: GaitLibrary) -> list[int]:
    """Samples of four tiles per step: its start, one third, two thirds and its end."""
    per_step = library.arrays["time"].shape[1] // 2
    within = [round(share * (per_step - 1) / 3) for share in range(4)]
    return [step * per_step + sample for step in range(2) for sample in within]


def draw_tiles(row: Sequence[Axes], library: GaitLibrary, gait: int) -> None:
    """Draw the tiles of one gait, with the time below each."""
    samples = tile_samples(library)
    times = library.arrays["time"][gait, samples]
    for axes, posture, time in zip(row, postures(library, gait, samples), times, strict=True):
        _tile(axes, posture)
        axes.set_xlabel(f"{time:.2f} s", labelpad=1)


def _tile(axes: Axes, posture: Posture) -> None:
    x = float(posture.base[0])
    draw_ground(axes, x - _HALF_WIDTH, x + _HALF_WIDTH)
    draw_posture(axes, posture)
    axes.set(xlim=(x - _HALF_WIDTH, x + _HALF_WIDTH), ylim=(-0.05, _TOP), aspect="equal")
    axes.set(xticks=[], yticks=[])
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
