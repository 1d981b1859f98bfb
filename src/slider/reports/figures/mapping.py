"""Eq. 1: virtual-knee leg and prismatic leg, and the printed map against the exact one."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Patch, Polygon
from scipy.integrate import cumulative_trapezoid

from slider.config.robot import Geometry, Mechanism
from slider.library.reader import GaitLibrary
from slider.reports.figures.style import DARK, EMPTY, LIGHT, MIDDLE, new_figure
from slider.robot import knee_map
from slider.robot.names import EXTENSION, LEG_MOTORS

_TILT = -0.25  # hip pitch of the prismatic leg [rad]
_NORMAL = -np.pi / 2  # from a leg's pitch to that of its forward normal
_HIP = np.zeros(2)


@dataclass(frozen=True)
class LegPair:
    """Angles [rad] about +y and lengths [m] at a knee flexion; the foot is level.

    ``knee``, ``exact`` and ``printed`` are hip pitch and ankle angle of the virtual leg, and of the
    prismatic leg by the exact and by the printed map.
    """

    flexion: float
    thigh: float
    shank: float
    length: float
    knee: tuple[float, float]
    exact: tuple[float, float]
    printed: tuple[float, float]

    @classmethod
    def of(cls, robot: Mechanism, flexion: float) -> "LegPair":
        """Legs whose prismatic one has the common pitch of all drawn ones."""
        l1, l2 = robot.sliding_leg.thigh_length, robot.sliding_leg.shank_length
        length = float(knee_map.leg_length(np.array(flexion), l1, l2))
        shift = _mapped((0.0, 0.0), flexion, l1, l2, "exact")
        knee = (_TILT - shift[0], -_TILT - shift[1])
        exact, printed = (_mapped(knee, flexion, l1, l2, v) for v in ("exact", "paper"))
        return cls(flexion, l1, l2, length, knee, exact, printed)

    @property
    def middle(self) -> np.ndarray:
        """Place (2,) of the virtual knee in x and z, from the hip [m]."""
        return self.thigh * _down(self.knee[0])

    @property
    def ankle(self) -> np.ndarray:
        """Place (2,) of the ankle of both legs."""
        return self.middle + self.shank * _down(self.knee[0] - self.flexion)


def draw_legs(axes: Axes, geometry: Geometry, legs: LegPair, lettered: bool) -> None:
    """Draw both from the hip down, x to the right, z up; letters of eq. 1 where asked for."""
    joints = np.stack([_HIP, legs.middle, legs.ankle], 1)
    axes.plot(*joints, color=DARK, linewidth=2.0, label="virtual-knee leg")
    for (pitch, _), colour, dash, width, label in (
        (legs.exact, MIDDLE, "-", 2.0, "prismatic leg, exact map"),
        (legs.printed, LIGHT, "--", 1.2, "prismatic leg, eq. 1 as printed"),
    ):
        leg = np.stack([_HIP, legs.length * _down(pitch)], 1)
        axes.plot(*leg, dash, color=colour, linewidth=width, label=label)
    sole = [[-geometry.heel, -geometry.ankle_height], [geometry.toe, -geometry.ankle_height]]
    foot = np.vstack([legs.ankle, legs.ankle + sole])
    axes.add_patch(Polygon(foot, facecolor="white", edgecolor=DARK, zorder=2))
    axes.plot(*joints, "o", color=DARK, markerfacecolor="white", markersize=4.5)
    axes.set_title(f"θ = {legs.flexion:.2f} rad", fontsize=8)
    axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-0.34, 0.36))
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    texts = [f"$l = {legs.length:.3f}$ m"]
    for prime, (alpha, beta) in (("'", legs.knee), ("", legs.exact)):
        texts.append(f"$q{prime}_α = {alpha:.2f}$, $q{prime}_β = {beta:.2f}$")
    axes.set_xlabel("\n".join(texts), fontsize=7)
    if lettered:
        _letter(axes, legs)


def _mapped(
    hip_and_ankle: tuple[float, float], flexion: float, l1: float, l2: float, variant: str
) -> tuple[float, float]:
    pitch, theta, ankle = np.array([hip_and_ankle[0], flexion, hip_and_ankle[1]])
    leg = knee_map.positions(pitch, theta, ankle, l1, l2, variant)
    return float(leg.hip_pitch), float(leg.ankle)


def _letter(axes: Axes, legs: LegPair) -> None:
    """A letter for each length; an arc for each angle, between the lines that it is between."""
    for start, end, colour, text in (
        (_HIP, legs.middle, DARK, "$l_1$"),
        (legs.middle, legs.ankle, DARK, "$l_2$"),
        (_HIP, legs.ankle, MIDDLE, "$l$"),
    ):
        x, z = (end - start) / np.linalg.norm(end - start)
        _text(axes, 0.6 * end + 0.4 * start + 0.035 * np.array([z, -x]), text, colour)

    thigh, leg, shank = legs.knee[0], legs.exact[0], legs.knee[0] - legs.flexion
    for start, pitch, colour in (
        (_HIP, 0.0, DARK),
        (legs.middle, thigh, DARK),
        (legs.ankle, leg + _NORMAL, MIDDLE),
        (legs.ankle, shank + _NORMAL, DARK),
    ):
        line = np.stack([start, start + 0.4 * legs.length * _down(pitch)], 1)
        axes.plot(*line, ":", color=colour, linewidth=0.7)
    for centre, size, first, second, colour, text in (
        (_HIP, 0.36, 0.0, leg, MIDDLE, "$q_α$"),
        (_HIP, 0.24, 0.0, thigh, DARK, "$q'_α$"),
        (legs.middle, 0.2, shank, thigh, DARK, "θ"),
        (legs.ankle, 0.38, leg + _NORMAL, _NORMAL, MIDDLE, "$q_β$"),
        (legs.ankle, 0.26, shank + _NORMAL, _NORMAL, DARK, "$q'_β$"),
    ):
        low, high = sorted(np.degrees([-np.pi / 2 - first, -np.pi / 2 - second]))
        axes.add_patch(
            Arc((centre[0], centre[1]), size, size, theta1=low, theta2=high, color=colour)
        )
        _text(axes, centre + (0.5 * size + 0.045) * _down((first + second) / 2), text, colour)


def _text(axes: Axes, place: np.ndarray, text: str, colour: str) -> None:
    axes.text(place[0], place[1], text, color=colour, fontsize=7.5, ha="center", va="center")


def _down(pitch: float) -> np.ndarray:
    """Unit vector (2,) in x and z along a leg of a pitch [rad] about +y."""
    return np.array([-np.sin(pitch), -np.cos(pitch)])


_NO_MAP = "The gaits are in the leg's own coordinates, without a map."
_START = 0.1  # knee flexion from which speed errors add up [rad]
_STOP = 1.75
_POSTURES = 4
_LOOKS = ((DARK, "-"), (MIDDLE, "--"))
_PANELS = (  # title, unit, curves
    ("angle", "rad", {"hip": "hip pitch", "ankle": "ankle"}),
    ("slide position", "m", {"slide": "printed length", "added_up": "printed velocity, added up"}),
    ("slide velocity", "m/rad", {"slide_rate": ""}),
)


def draw(library: GaitLibrary) -> Figure:
    """Legs at several flexions above; errors of angles, slide position and velocity below."""
    knee = library.robot.virtual_knee
    if knee is None:
        figure = new_figure(0.5)
        figure.text(0.5, 0.5, _NO_MAP, ha="center", va="center")
        return figure
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
    total = cumulative_trapezoid(errors["slide_rate"], theta, initial=0.0)
    errors["added_up"] = total - np.interp(_START, theta, total)
    for axes, (title, unit, curves) in zip(panels, _PANELS, strict=True):
        for (name, label), (colour, dash) in zip(curves.items(), _LOOKS, strict=False):
            axes.plot(theta, errors[name], dash, color=colour, label=label)
        axes.set(title=f"{title} error", ylabel=f"printed − exact [{unit}]")
        axes.axvspan(*used, color=EMPTY, zorder=0)
        axes.set_xlabel("knee flexion θ [rad]")
        axes.set_xlim(0.0, _STOP)
    handles, labels = panels[0].get_legend_handles_labels()
    used_range = Patch(facecolor=EMPTY, edgecolor=LIGHT)
    panels[0].legend([*handles, used_range], [*labels, "θ in the library"])
    panels[1].margins(y=0.3)
    panels[1].legend(loc="upper center", fontsize=7)
    return figure


def flexions(library: GaitLibrary) -> tuple[float, float]:
    """Least and greatest knee flexion [rad] of the gaits."""
    used = library.arrays["knee_positions"][..., EXTENSION::LEG_MOTORS]
    return float(used.min()), float(used.max())


def caption(library: GaitLibrary) -> str:
    """What is printed, and how far it is off where the gaits of this library use it."""
    knee = library.robot.virtual_knee
    if knee is None:
        return f"{_NO_MAP}\n"
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
    zero, variants = np.zeros_like(theta), ("paper", "exact")
    places = [knee_map.positions(zero, theta, zero, l1, l2, v) for v in variants]
    rates = [knee_map.velocities(zero, theta, zero + 1, zero, l1, l2, v) for v in variants]
    errors = {}
    for suffix, (printed, exact) in (("", places), ("_rate", rates)):
        for name, part in (("hip", "hip_pitch"), ("ankle", "ankle"), ("slide", "length")):
            errors[name + suffix] = getattr(printed, part) - getattr(exact, part)
    return errors
