"""How much neighbouring gaits differ, over the grid and by channel."""

import numpy as np
from matplotlib.figure import Figure

from slider.library.measures import Smoothness, smoothness
from slider.library.reader import GaitLibrary
from slider.reports.figures.maps import VelocityMap, draw_map
from slider.reports.figures.style import DARK, new_figure
from slider.robot.names import CHANNELS, command_text


def draw(library: GaitLibrary) -> Figure:
    """Map of each gait's greatest jump, and the greatest jump of each channel."""
    measured = _measure(library)
    jumps = 100 * measured.per_gait(len(library))
    figure = new_figure(4.9)
    top, bottom = figure.subplots(2, 1, height_ratios=(1, 2.4))
    item = VelocityMap("greatest jump to a neighbouring gait", jumps, "% of range")
    draw_map(top, library, item)
    active = [i for i, name in enumerate(CHANNELS) if "upper_foot" not in name]
    by_channel = 100 * measured.jumps.max(axis=0, initial=0.0)[active]
    order = np.argsort(by_channel)
    bottom.barh([CHANNELS[active[i]] for i in order], by_channel[order], color=DARK, height=0.6)
    bottom.set(xlabel="greatest jump of the channel between neighbouring gaits [% of its range]")
    bottom.tick_params(axis="y", labelsize=6.5, length=0)
    bottom.grid(visible=False, axis="y")
    return figure


def caption(library: GaitLibrary) -> str:
    """The scale of a jump, and where the greatest one is."""
    measured = _measure(library)
    text = (
        "Difference between gaits that follow one another in vx or in vy, at the same sample, as a "
        "share of the channel's range over the whole library (all gaits and samples). "
    )
    if not len(measured.pairs):
        return text + "This library has no neighbouring gaits.\n"
    first, second, channel = measured.worst
    places = [command_text(command) for command in library.commands[[first, second]]]
    return text + (
        f"The greatest is {100 * measured.largest:.1f} % of {CHANNELS[channel]}, between "
        f"{places[0]} and {places[1]}.\n"
    )


def _measure(library: GaitLibrary) -> Smoothness:
    return smoothness(library.commands, library.arrays["samples"])
