"""One leg twice: with the virtual knee and with the slide, by eq. 1."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Polygon

from slider.config.robot import Geometry, Mechanism
from slider.reports.figures.style import DARK, LIGHT, MIDDLE
from slider.robot import knee_map

_TILT = -0.25  # hip pitch of the prismatic leg [rad]
_NORMAL = -np.pi / 2  # from a leg's pitch to that of its forward normal
_HIP = np.zeros(2)


@dataclass(frozen=True)
class LegPair:
    """Angles [rad] about +y and lengths [m] at a knee flexion; the foot is level.

    Attributes:
        flexion: θ.
        thigh, shank, length: l₁, l₂ and l.
        knee, exact, printed: hip pitch and ankle angle of the virtual leg, and of the prismatic
            leg by the exact and by the printed map.
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
        l1, l2 = robot.virtual_knee.thigh_length, robot.virtual_knee.shank_length
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
    _line(axes, [_HIP, legs.middle, legs.ankle], DARK, width=2.0, label="virtual-knee leg")
    exact, printed = (legs.length * _down(pitch) for pitch, _ in (legs.exact, legs.printed))
    _line(axes, [_HIP, exact], MIDDLE, width=2.0, label="prismatic leg, exact map")
    _line(axes, [_HIP, printed], LIGHT, "--", 1.2, "prismatic leg, eq. 1 as printed")
    sole = [[-geometry.heel, -geometry.ankle_height], [geometry.toe, -geometry.ankle_height]]
    foot = np.vstack([legs.ankle, legs.ankle + sole])
    axes.add_patch(Polygon(foot, facecolor="white", edgecolor=DARK, zorder=2))
    joints = np.stack([_HIP, legs.middle, legs.ankle], 1)
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
        _lengths(axes, legs)
        _angles(axes, legs)


def _mapped(
    hip_and_ankle: tuple[float, float], flexion: float, l1: float, l2: float, variant: str
) -> tuple[float, float]:
    pitch, theta, ankle = np.array([hip_and_ankle[0], flexion, hip_and_ankle[1]])
    leg = knee_map.positions(pitch, theta, ankle, l1, l2, variant)
    return float(leg.hip_pitch), float(leg.ankle)


def _line(
    axes: Axes,
    points: list[np.ndarray],
    colour: str,
    dash: str = "-",
    width: float = 0.7,
    label: str | None = None,
) -> None:
    x, z = np.stack(points, 1)
    axes.plot(x, z, dash, color=colour, linewidth=width, label=label)


def _lengths(axes: Axes, legs: LegPair) -> None:
    for start, end, colour, text in (
        (_HIP, legs.middle, DARK, "$l_1$"),
        (legs.middle, legs.ankle, DARK, "$l_2$"),
        (_HIP, legs.ankle, MIDDLE, "$l$"),
    ):
        x, z = (end - start) / np.linalg.norm(end - start)
        _text(axes, 0.6 * end + 0.4 * start + 0.035 * np.array([z, -x]), text, colour)


def _angles(axes: Axes, legs: LegPair) -> None:
    """An arc for each angle, between the lines that it is measured from and to."""
    thigh, leg, shank = legs.knee[0], legs.exact[0], legs.knee[0] - legs.flexion
    for start, pitch, colour in (
        (_HIP, 0.0, DARK),
        (legs.middle, thigh, DARK),
        (legs.ankle, leg + _NORMAL, MIDDLE),
        (legs.ankle, shank + _NORMAL, DARK),
    ):
        _line(axes, [start, start + 0.4 * legs.length * _down(pitch)], colour, ":")
    for centre, size, first, second, colour, text in (
        (_HIP, 0.36, 0.0, leg, MIDDLE, "$q_α$"),
        (_HIP, 0.24, 0.0, thigh, DARK, "$q'_α$"),
        (legs.middle, 0.2, shank, thigh, DARK, "θ"),
        (legs.ankle, 0.38, leg + _NORMAL, _NORMAL, MIDDLE, "$q_β$"),
        (legs.ankle, 0.26, shank + _NORMAL, _NORMAL, DARK, "$q'_β$"),
    ):
        low, high = sorted(np.degrees([-np.pi / 2 - first, -np.pi / 2 - second]))
        x, z = (float(value) for value in centre)
        axes.add_patch(Arc((x, z), size, size, theta1=low, theta2=high, color=colour))
        _text(axes, centre + (0.5 * size + 0.045) * _down((first + second) / 2), text, colour)


def _text(axes: Axes, place: np.ndarray, text: str, colour: str) -> None:
    x, z = (float(value) for value in place)
    axes.text(x, z, text, color=colour, fontsize=7.5, ha="center", va="center")


def _down(pitch: float) -> np.ndarray:
    """Unit vector (2,) in x and z along a leg of a pitch [rad] about +y."""
    return np.array([-np.sin(pitch), -np.cos(pitch)])
