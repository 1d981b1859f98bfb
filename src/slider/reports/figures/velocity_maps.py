"""Cost, step time and use of the drives over the grid of commanded velocities."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from slider.library import loads
from slider.library.contents import LibraryContents
from slider.reports.figures.maps import VelocityMap, draw_map
from slider.reports.figures.style import new_figure

CAPTION = """\
One cell per gait; a red cross marks a velocity whose gait did not converge, and white is outside
the grid. The cost is that of the optimisation (`gait.cost`). The torque is the greatest of all
rotary joints over the walk as a share of that joint's limit; slide force and slide speed likewise,
against {force:g} N and {speed:g} m/s.
"""


def draw(library: LibraryContents) -> Figure:
    """One map below the other."""
    return draw_maps(library, library_maps(library))


def caption(library: LibraryContents) -> str:
    """What the maps show."""
    slide = library.robot.limits["slide"]
    return CAPTION.format(force=slide.effort, speed=slide.speed)


def library_maps(library: LibraryContents) -> list[VelocityMap]:
    """The maps that the library alone can give."""
    shares = "% of limit"
    return [
        VelocityMap("cost", library.arrays["cost"], "N² m²/s"),
        VelocityMap("step time", library.arrays["step_time"].mean(axis=1), "s"),
        VelocityMap("peak torque", 100 * loads.peak_torque_share(library), shares),
        VelocityMap("peak slide force", 100 * loads.slide_force_share(library), shares),
        VelocityMap("peak slide speed", 100 * loads.slide_speed_share(library), shares),
    ]


def draw_maps(library: LibraryContents, maps: Sequence[VelocityMap]) -> Figure:
    """Any maps, one below the other, with a common velocity axis."""
    figure = new_figure(1.25 * len(maps) + 0.3)
    panels = figure.subplots(len(maps), 1, sharex=True, squeeze=False)[:, 0]
    for axes, item in zip(panels, maps, strict=True):
        draw_map(axes, library, item)
        axes.label_outer()
    return figure
