"""Eq. 1: the printed map from virtual knee to slide against the exact one."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from scipy.integrate import cumulative_trapezoid

from slider.library.reader import GaitLibrary
from slider.reports.figures.style import DARK, EMPTY, LIGHT, MIDDLE, new_figure
from slider.robot import knee_map

_START = 0.1  # knee flexion from which speed errors add up [rad]
_STOP = 1.75
_VARIANTS = ("paper", "exact")


def draw(library: GaitLibrary) -> Figure:
    """Errors of angles, slide position and slide velocity over the knee angle."""
    knee = library.robot.virtual_knee
    theta = np.linspace(0.0, _STOP, 351)
    errors = map_errors(theta, knee.thigh_length, knee.shank_length)
    figure = new_figure(2.7)
    panels = figure.subplots(1, 3)
    _angles(panels[0], theta, errors)
    _slide_position(panels[1], theta, errors)
    _slide_velocity(panels[2], theta, errors)
    used = library.arrays["knee_positions"][..., [3, 8]]
    for axes in panels:
        axes.axvspan(float(used.min()), float(used.max()), color=EMPTY, zorder=0)
        axes.set_xlabel("knee flexion θ [rad]")
        axes.set_xlim(0.0, _STOP)
    handles, labels = panels[0].get_legend_handles_labels()
    used_range = Patch(facecolor=EMPTY, edgecolor=LIGHT)
    panels[0].legend([*handles, used_range], [*labels, "θ in the library"])
    return figure


def caption(library: GaitLibrary) -> str:
    """What is printed, and how far it is off where the gaits of this library use it."""
    knee = library.robot.virtual_knee
    used = library.arrays["knee_positions"][..., [3, 8]]
    theta = np.linspace(float(used.min()), float(used.max()), 200)
    errors = map_errors(theta, knee.thigh_length, knee.shank_length)
    worst = {name: float(np.abs(error).max()) for name, error in errors.items()}
    return (
        f"Printed minus exact, for a thigh of {knee.thigh_length:g} m and a shank of "
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
    axes.legend(loc="upper center")


def _slide_velocity(axes: Axes, theta: np.ndarray, errors: dict[str, np.ndarray]) -> None:
    axes.plot(theta, errors["slide_rate"], color=DARK)
    axes.axhline(0.0, color=LIGHT, linewidth=0.8)
    axes.set(title="slide velocity error", ylabel="printed − exact [m/rad]")
