"""Eq. 1: the printed map from virtual-knee to prismatic leg against the exact one."""

import numpy as np
from matplotlib.figure import Figure

from slider.library.reader import GaitLibrary
from slider.reports.figures.style import DARK, EMPTY, MIDDLE, new_figure
from slider.robot import knee_map
from slider.robot.names import EXTENSION, LEG_GAIT_JOINTS

_NO_MAP = "The gaits are in the leg's own coordinates, without a map."
_STOP = 1.75  # [rad]
_LOOKS = ((DARK, "-"), (MIDDLE, "--"))
_PANELS = (  # title, unit, curves
    ("angle", "rad", {"hip": "hip pitch", "ankle": "ankle"}),
    ("slide velocity", "m/rad", {"slide_rate": ""}),
)


def draw(library: GaitLibrary) -> Figure:
    """Errors of angles and slide velocity over the knee flexion."""
    knee = library.robot.virtual_knee
    if knee is None:
        figure = new_figure(0.5)
        figure.text(0.5, 0.5, _NO_MAP, ha="center", va="center")
        return figure
    figure = new_figure(2.6)
    theta = np.linspace(0.0, _STOP, 351)
    errors = map_errors(theta, knee.thigh_length, knee.shank_length)
    panels = figure.subplots(1, 2)
    for axes, (title, unit, curves) in zip(panels, _PANELS, strict=True):
        for (name, label), (colour, dash) in zip(curves.items(), _LOOKS, strict=False):
            axes.plot(theta, errors[name], dash, color=colour, label=label)
        axes.axvspan(*flexions(library), color=EMPTY, zorder=0)
        axes.set(title=f"{title} error", ylabel=f"printed − exact [{unit}]")
        axes.set(xlabel="knee flexion θ [rad]", xlim=(0.0, _STOP))
    panels[0].patches[0].set_label("θ in the library")
    panels[0].legend()
    return figure


def flexions(library: GaitLibrary) -> tuple[float, float]:
    """Least and greatest knee flexion [rad] of the gaits."""
    used = library.arrays["knee_positions"][..., EXTENSION::LEG_GAIT_JOINTS]
    return float(used.min()), float(used.max())


def caption(library: GaitLibrary) -> str:
    """What is printed, and its errors over the flexions that the gaits of this library use."""
    knee = library.robot.virtual_knee
    if knee is None:
        return _NO_MAP
    theta = np.linspace(*flexions(library), 200)
    errors = map_errors(theta, knee.thigh_length, knee.shank_length)
    worst = {name: float(np.abs(error).max()) for name, error in errors.items()}
    return (
        f"Printed minus exact eq. 1, for a thigh of {knee.thigh_length:g} m and a shank of "
        f"{knee.shank_length:g} m; grey: the knee angles that the gaits of this library use. "
        f"There the printed angles are off by up to {worst['hip']:.3f} rad (hip) and "
        f"{worst['ankle']:.3f} rad (ankle), and the printed slide velocity by up to "
        f"{worst['slide_rate']:.3f} m/rad (slide speed per knee speed). "
        "The printed length itself is exact."
    )


def map_errors(theta: np.ndarray, l1: float, l2: float) -> dict[str, np.ndarray]:
    """Printed minus exact at knee flexions (N,) [rad].

    Returns:
        ``hip``, ``ankle`` [rad] and ``slide`` [m]; ``slide_rate`` [m/rad] per knee speed.
    """
    printed, exact = (knee_map.triangle(theta, l1, l2, name) for name in ("paper", "exact"))
    hip, ankle = np.subtract(exact.shifts, printed.shifts)  # the joints subtract the shifts
    slide, slide_rate = printed.length - exact.length, printed.rates[2] - exact.rates[2]
    return {"hip": hip, "ankle": ankle, "slide": slide, "slide_rate": slide_rate}
