"""Eq. 1: virtual-knee leg and prismatic leg, and the printed map against the exact one."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from scipy.integrate import cumulative_trapezoid

from slider.library.reader import GaitLibrary
from slider.reports.figures.leg_pair import LegPair, draw_legs
from slider.reports.figures.style import DARK, EMPTY, LIGHT, MIDDLE, new_figure
from slider.robot import knee_map
from slider.robot.names import KNEE_JOINTS, SIDES

_START = 0.1  # knee flexion from which speed errors add up [rad]
_STOP = 1.75
_VARIANTS = ("paper", "exact")
_KNEES = [KNEE_JOINTS.index(f"{side}_knee") for side in SIDES]
_POSTURES = 4


def draw(library: GaitLibrary) -> Figure:
    """Legs at several flexions above; errors of angles, slide position and velocity below."""
    knee = library.robot.virtual_knee
    used = flexions(library)
    figure = new_figure(5.7)
    figure.set_layout_engine("constrained", w_pad=0.1)
    above, below = np.asarray(figure.subfigures(2, 1, height_ratios=(1.25, 1.0)))
    panels = above.subplots(1, _POSTURES, sharex=True, sharey=True)
    for axes, flexion in zip(panels, np.linspace(*used, _POSTURES), strict=True):
        legs = LegPair.of(library.robot, float(flexion))
        draw_legs(axes, library.robot.geometry, legs, lettered=axes is panels[-1])
    above.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    theta = np.linspace(0.0, _STOP, 351)
    errors = map_errors(theta, knee.thigh_length, knee.shank_length)
    panels = below.subplots(1, 3)
    _angles(panels[0], theta, errors)
    _slide_position(panels[1], theta, errors)
    _slide_velocity(panels[2], theta, errors)
    for axes in panels:
        axes.axvspan(*used, color=EMPTY, zorder=0)
        axes.set_xlabel("knee flexion θ [rad]")
        axes.set_xlim(0.0, _STOP)
    handles, labels = panels[0].get_legend_handles_labels()
    used_range = Patch(facecolor=EMPTY, edgecolor=LIGHT)
    panels[0].legend([*handles, used_range], [*labels, "θ in the library"])
    return figure


def flexions(library: GaitLibrary) -> tuple[float, float]:
    """Least and greatest knee flexion [rad] of the gaits."""
    used = library.arrays["knee_positions"][..., _KNEES]
    return float(used.min()), float(used.max())


def caption(library: GaitLibrary) -> str:
    """What is printed, and how far it is off where the gaits of this library use it."""
    knee = library.robot.virtual_knee
    theta = np.linspace(*flexions(library), 200)
    errors = map_errors(theta, knee.thigh_length, knee.shank_length)
    worst = {name: float(np.abs(error).max()) for name, error in errors.items()}
    return (
        "Above: the virtual-knee leg and the prismatic leg that eq. 1 makes of it, from the "
        "straightest to the most bent knee of this library, with the same hip, ankle and foot; the "
        "prismatic leg's hip pitch and the foot stay. Angles turn about the axis into the page: "
        "q_α from the vertical to the leg, q_β from the leg's normal to the foot. "
        f"Below: printed minus exact, for a thigh of {knee.thigh_length:g} m and a shank of "
        f"{knee.shank_length:g} m; grey: the knee angles that the gaits of this library use. "
        f"There the printed angles are off by up to {worst['hip']:.3f} rad (hip) and "
        f"{worst['ankle']:.3f} rad (ankle), and the printed slide velocity by up to "
        f"{worst['slide_rate']:.3f} m/rad (slide speed per knee speed). "
        "The printed length itself is exact; dashed is the position that one gets by adding up "
        f"the printed velocities from θ = {_START:g} rad on.\n"
    )


def map_errors(theta: np.ndarray, l1: float, l2: float) -> dict[str, np.ndarray]:
    """Printed minus exact at knee flexions (N,) [rad].

    Returns:
        ``hip``, ``ankle`` [rad] and ``slide`` [m] of positions; ``hip_rate``, ``ankle_rate``
        [rad/rad] and ``slide_rate`` [m/rad] of velocities per knee speed.
    """
    zero = np.zeros_like(theta)
    places = [knee_map.positions(zero, theta, zero, l1, l2, v) for v in _VARIANTS]
    rates = [knee_map.velocities(zero, theta, zero + 1, zero, l1, l2, v) for v in _VARIANTS]
    errors = {}
    for suffix, (printed, exact) in (("", places), ("_rate", rates)):
        errors[f"hip{suffix}"] = printed.hip_pitch - exact.hip_pitch
        errors[f"ankle{suffix}"] = printed.ankle - exact.ankle
        errors[f"slide{suffix}"] = printed.length - exact.length
    return errors


def _angles(axes: Axes, theta: np.ndarray, errors: dict[str, np.ndarray]) -> None:
    axes.plot(theta, errors["hip"], color=DARK, label="hip pitch")
    axes.plot(theta, errors["ankle"], color=MIDDLE, linestyle="--", label="ankle")
    axes.set(title="angle error", ylabel="printed − exact [rad]")


def _slide_position(axes: Axes, theta: np.ndarray, errors: dict[str, np.ndarray]) -> None:
    total = cumulative_trapezoid(errors["slide_rate"], theta, initial=0.0)
    total = total - np.interp(_START, theta, total)
    axes.plot(theta, errors["slide"], color=DARK, label="printed length")
    axes.plot(theta, total, color=MIDDLE, linestyle="--", label="printed velocity, added up")
    axes.set(title="slide position error", ylabel="printed − exact [m]")
    axes.margins(y=0.3)
    axes.legend(loc="upper center", fontsize=7)


def _slide_velocity(axes: Axes, theta: np.ndarray, errors: dict[str, np.ndarray]) -> None:
    axes.plot(theta, errors["slide_rate"], color=DARK)
    axes.axhline(0.0, color=LIGHT, linewidth=0.8)
    axes.set(title="slide velocity error", ylabel="printed − exact [m/rad]")
