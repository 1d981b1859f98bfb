"""Cost, step time and use of the drives over the grid of commanded velocities."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from slider.library import loads
from slider.library.reader import GaitLibrary
from slider.reports.figures.maps import VelocityMap, draw_map
from slider.reports.figures.style import new_figure

CAPTION = """\
One cell per gait; a red cross marks a velocity whose gait did not converge, and white is outside
the grid. The cost is that of the optimisation (`gait.cost`). Torque and voltage are the greatest
of all motors over the walk, as shares of the motor's torque limit and of its torque-speed line.
"""


def draw(library: GaitLibrary) -> Figure:
    """One map below the other."""
    return draw_maps(library, library_maps(library))


def caption(library: GaitLibrary) -> str:
    """What the maps show."""
    return CAPTION


def library_maps(library: GaitLibrary) -> list[VelocityMap]:
    """The maps that the library alone can give."""
    return [
        VelocityMap("cost", library.arrays["cost"], library.cost_unit),
        VelocityMap("step time", library.arrays["step_time"].mean(axis=1), "s"),
        VelocityMap("motor torque", 100 * loads.torque_share(library), "% of limit"),
        VelocityMap("motor voltage", 100 * loads.voltage_share(library), "% of the bus"),
        VelocityMap("slide speed", loads.slide_speed(library), "m/s"),
    ]


def draw_maps(library: GaitLibrary, maps: Sequence[VelocityMap]) -> Figure:
    """Any maps, one below the other, with a common velocity axis."""
    figure = new_figure(1.25 * len(maps) + 0.3)
    panels = figure.subplots(len(maps), 1, sharex=True, squeeze=False)[:, 0]
    for axes, item in zip(panels, maps, strict=True):
        draw_map(axes, library, item)
        axes.label_outer()
    return figure
