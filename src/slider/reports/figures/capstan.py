"""The drive of slide and ankle, a differential capstan in the paper's figures, and its limits."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from slider.config.robot import Capstan, Geometry
from slider.library.measures import motor_torques
from slider.library.reader import GaitLibrary
from slider.reports.figures.gaits import forward_gaits
from slider.reports.figures.style import DARK, EMPTY, LIGHT, MIDDLE, new_figure
from slider.robot.names import ANKLE, EXTENSION, NUM_JOINTS, NUM_MOTORS
from slider.robot.transmission import Transmission

_MOTORS = [EXTENSION, ANKLE]  # of the left leg, as its joints
_DOTS = "Dots: samples of the left leg's motors in the fastest gait straight ahead.\n"
_SHARE = 0.5  # of the joints' ranges that the drawn motions take
_GAP = 0.7  # from the leg's axis to a cable at its drum, as a share of the drum's radius


def draw(library: GaitLibrary) -> Figure:
    """Three motions, and torque and speed of both motors in the fastest gait straight ahead.

    Without a capstan there are no motions, and the motors have a panel each.
    """
    drive, capstan = Transmission.of(library.robot), library.robot.capstan
    figure = new_figure(3.3)
    if capstan is None:
        panels = zip(figure.subplots(1, 2), _MOTORS, ("slide", "ankle"), strict=True)
        for axes, motor, name in panels:
            _limits(axes, library, drive, {name: motor})
        return figure
    *panels, limits = figure.subplots(1, 4, width_ratios=(1, 1, 1, 2.4))
    reach = _SHARE * np.array([library.robot.joints[n].upper for n in ("slide", "ankle")])
    moves = {"same sense": (1, 0), "opposite senses": (0, 1), "superposition": (1, 1)}
    for axes, (title, shares) in zip(panels, moves.items(), strict=True):
        _motion(axes, library, drive, capstan, reach * shares)
        axes.set_title(title)
    _limits(limits, library, drive, dict(zip(("motor 1", "motor 2"), _MOTORS, strict=True)))
    return figure


def caption(library: GaitLibrary) -> str:
    """Radius and ratio, and what the lower panels compare."""
    capstan = library.robot.capstan
    if capstan is None:
        return "Torques (forces of the slide) that the motors can make over their speeds. " + _DOTS
    motor = library.robot.drives["capstan"]
    return (
        f"Two equal motors per leg with drums of {1000 * capstan.drum_radius:g} mm; a foot ratio "
        f"of {capstan.foot_ratio:g}; cables from the foot's lever over the drum to the upper "
        "foot's. Motors that turn in the same sense move the slide, in opposite senses they turn "
        "the foot, and the two add up (light: the nominal posture; the simulated upper foot is a "
        "passive joint, here it follows the cables). On the right the torques that a motor can "
        f"make over its speed ({motor.torque:g} N m at rest, {motor.speed:g} rad/s without load). "
        + _DOTS
    )


def angles_of(drive: Transmission, slide: np.ndarray, ankle: np.ndarray) -> np.ndarray:
    """Angles or speeds (..., 2) of the left leg's capstan motors, of slide and ankle (...)."""
    joints = np.zeros((*np.shape(slide), NUM_JOINTS))
    joints[..., EXTENSION], joints[..., ANKLE] = slide, ankle
    return drive.angles(joints)[..., _MOTORS]


def _motion(
    axes: Axes, library: GaitLibrary, drive: Transmission, capstan: Capstan, joints: np.ndarray
) -> None:
    """The leg before and after, with the motors' turns; ``joints`` are slide and ankle."""
    first, second = angles_of(drive, *joints)
    radius, geometry = capstan.drum_radius, library.robot.geometry
    _leg(axes, geometry, capstan, (0.0, 0.0), LIGHT)
    _leg(axes, geometry, capstan, (joints[0], joints[1]), DARK)
    for side, turn in ((1.0, first), (-1.0, second)):  # motor 1 pulls at the toe
        centre = np.array([side * (1 + _GAP) * radius, 0.0])
        axes.add_patch(Circle(tuple(centre), radius, facecolor="white", edgecolor=DARK, zorder=5))
        for angle, colour in ((0.0, LIGHT), (turn, MIDDLE)):
            # Cables run between the drums: where both go down, these turn towards each other.
            tip = centre + radius * np.array([-side * np.sin(angle), np.cos(angle)])
            axes.plot(*np.stack([centre, tip], 1), color=colour, linewidth=1.2, zorder=6)
    axes.set_xlabel(f"motors {first:+.1f},\n{second:+.1f} rad")
    bottom = geometry.leg_length + _SHARE * library.robot.joints["slide"].upper
    axes.set(xlim=(-0.13, 0.13), aspect="equal", xticks=[], yticks=[])
    axes.set_ylim(-bottom - 2 * geometry.ankle_height - 0.03, geometry.upper_foot_height + 0.1)
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)


def _leg(
    axes: Axes, geometry: Geometry, capstan: Capstan, joints: tuple[float, float], colour: str
) -> None:
    slide, ankle = joints
    bottom = np.array([0.0, -geometry.leg_length - slide])
    top = bottom + [0.0, geometry.leg_length + geometry.upper_foot_height]
    axes.plot(*np.stack([bottom, top], 1), color=colour, linewidth=2.2, zorder=2)
    # About +y, with x to the right and z up: a positive angle lowers the toe.
    turn = np.array([[np.cos(ankle), np.sin(ankle)], [-np.sin(ankle), np.cos(ankle)]])
    sole = np.array([[-geometry.heel, -geometry.ankle_height], [0, 0]])
    sole = np.vstack([sole, [geometry.toe, -geometry.ankle_height]])
    for place, sign in ((bottom, 1.0), (top, -1.0)):
        shape = place + sole * [1.0, sign] @ turn.T
        axes.add_patch(Polygon(shape, facecolor="white", edgecolor=colour, zorder=3))
    lever = capstan.drum_radius / capstan.foot_ratio  # so that the cable's length stays
    for place in (bottom, top):
        bar = np.stack([place - turn @ [lever, 0.0], place + turn @ [lever, 0.0]], 1)
        axes.plot(*bar, color=colour, linewidth=1.2, zorder=4)
    for side in (-1.0, 1.0):
        ends = [place + turn @ [side * lever, 0.0] for place in (bottom, top)]
        drum = [side * _GAP * capstan.drum_radius, 0.0]
        axes.plot(*np.stack([ends[0], drum, ends[1]], 1), color=colour, linewidth=0.7, zorder=1)


def _limits(
    axes: Axes, library: GaitLibrary, drive: Transmission, motors: Mapping[str, int]
) -> None:
    """Torques that the motors can make over their speeds, and those of a gait."""
    one = next(iter(motors.values()))  # of several, which are equal
    speeds = np.linspace(-1.0, 1.0, 201) * drive.speed[one]
    limits = drive.torque_limits(np.repeat(speeds[:, None], NUM_MOTORS, axis=1))
    low, high = (limit[:, one] for limit in limits)
    axes.fill_between(speeds, low, high, facecolor=EMPTY, edgecolor=DARK, linewidth=0.8)
    gait = int(forward_gaits(library, 2)[-1])
    turning = drive.angles(library.arrays["samples"][gait][:, NUM_JOINTS : 2 * NUM_JOINTS])
    torques = motor_torques(library, gait)
    for (label, motor), colour in zip(motors.items(), (DARK, MIDDLE), strict=False):
        axes.plot(turning[:, motor], torques[:, motor], ".", color=colour, label=label)
    linear = "slide" in motors and library.robot.geometry.knee is None
    axes.set_xlabel("speed [m/s]" if linear else "speed [rad/s]")
    axes.set(title="limits", ylabel="force [N]" if linear else "torque [N m]")
    axes.margins(y=0.15)
    axes.legend(loc="upper center", ncols=2)
