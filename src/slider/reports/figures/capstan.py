"""The differential capstan drive of a leg, as in the paper's figures: motion, then limits.

All is drawn from ``slider.robot.transmission``: motor angles, efforts and torque limits.
"""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from slider.library.reader import GaitLibrary
from slider.reports.figures.gaits import forward_gaits
from slider.reports.figures.style import DARK, EMPTY, LIGHT, MIDDLE, new_figure
from slider.robot.names import JOINTS, MOTORS, NUM_JOINTS, SIDES
from slider.robot.transmission import Transmission

SLIDE, ANKLE = (JOINTS.index(f"left_{name}") for name in ("slide", "ankle"))
_MOTORS = [MOTORS.index(f"left_capstan_{number}") for number in (1, 2)]
_SHARE = 0.5  # of the joints' ranges that the drawn motions take
_GAP = 0.7  # from the leg's axis to a cable at its drum, as a share of the drum's radius
_LINES = (DARK, MIDDLE, LIGHT)
_DASHES = ("-", "--", "-.")
_SPEEDS = (0.0, 0.6, 0.8)  # of the slide, as shares of its no-load speed


def draw(library: GaitLibrary) -> Figure:
    """Three motions and the plane of motor angles above, the joints' limits below."""
    drive = Transmission.of(library.robot)
    figure = new_figure(6.3)
    figure.set_layout_engine("constrained", w_pad=0.1)
    above, below = np.asarray(figure.subfigures(2, 1, height_ratios=(1.25, 1.0)))
    panels = above.subplots(1, 4, width_ratios=(1, 1, 1, 2.4))
    reach = _SHARE * np.array([library.robot.joints[n].upper for n in ("slide", "ankle")])
    moves = {"same sense": (1, 0), "opposite senses": (0, 1), "superposition": (1, 1)}
    for axes, (title, shares) in zip(panels[:3], moves.items(), strict=True):
        _motion(axes, library, drive, reach * shares)
        axes.set_title(title)
    _angles(panels[3], library, drive)
    panels = below.subplots(1, 3)
    _efforts(panels[0], drive)
    _limits(panels[1], library, drive, SLIDE)
    _limits(panels[2], library, drive, ANKLE)
    return figure


def caption(library: GaitLibrary) -> str:
    """Radius and ratio, and what the lower panels compare."""
    capstan, motor = library.robot.capstan, library.robot.drives["capstan"]
    return (
        f"Two equal motors per leg with drums of {1000 * capstan.drum_radius:g} mm; a foot ratio "
        f"of {capstan.foot_ratio:g}; cables from the foot's lever over the drum to the upper "
        "foot's. Above: motors that turn in the same sense move the slide, in opposite senses they "
        "turn the foot, and the two add up (light: the nominal posture; the simulated upper foot "
        "is a passive joint, here it follows the cables). On the right the joints' ranges in the "
        "plane of the motor angles. Below: force and torque that the motors can make together "
        f"({motor.torque:g} N m each at rest, {motor.speed:g} rad/s without load), at three speeds "
        "of the slide; the torque-speed region of the slide with the ankle at rest and without "
        "torque, and the other way round. Dots are the samples of the fastest gait straight ahead; "
        "there both joints move.\n"
    )


def angles_of(drive: Transmission, slide: np.ndarray, ankle: np.ndarray) -> np.ndarray:
    """Angles or speeds (..., 2) of the left leg's capstan motors, of slide and ankle (...)."""
    return drive.angles(_joints(slide, ankle))[..., _MOTORS]


def effort_limits(drive: Transmission, joint: int, speeds: np.ndarray) -> np.ndarray:
    """Least and greatest effort (2, N) [N or N m] of slide or ankle at its speeds (N,).

    The other joint is at rest and has no effort: the motors share the load evenly.
    """
    still = np.zeros_like(speeds)
    turning = drive.angles(_joints(*((speeds, still) if joint == SLIDE else (still, speeds))))
    lower, upper = (limit[:, _MOTORS] for limit in drive.torque_limits(turning))
    gain = drive.matrix[_MOTORS, joint]
    ends = np.where(gain > 0, (lower, upper), (upper, lower)) * gain
    return 2 * np.array([ends[0].max(axis=1), ends[1].min(axis=1)])


def effort_region(drive: Transmission, slide_speed: float) -> np.ndarray:
    """Corners (5, 2) of slide force [N] and ankle torque [N m] at a slide speed [m/s], closed."""
    turning = drive.angles(_joints(np.array([slide_speed]), np.zeros(1)))
    lower, upper = (limit[0, _MOTORS] for limit in drive.torque_limits(turning))
    torques = np.zeros((5, len(MOTORS)))
    torques[:, _MOTORS[0]] = [lower[0], upper[0], upper[0], lower[0], lower[0]]
    torques[:, _MOTORS[1]] = [lower[1], lower[1], upper[1], upper[1], lower[1]]
    return drive.efforts(torques)[:, [SLIDE, ANKLE]]


def _joints(slide: np.ndarray, ankle: np.ndarray) -> np.ndarray:
    joints = np.zeros((*np.shape(slide), NUM_JOINTS))
    joints[..., SLIDE], joints[..., ANKLE] = slide, ankle
    return joints


def _motion(axes: Axes, library: GaitLibrary, drive: Transmission, joints: np.ndarray) -> None:
    """The leg before and after, with the motors' turns; ``joints`` are slide and ankle."""
    first, second = angles_of(drive, *joints)
    radius = library.robot.capstan.drum_radius
    _leg(axes, library, (0.0, 0.0), LIGHT)
    _leg(axes, library, (joints[0], joints[1]), DARK)
    for side, turn in ((1.0, first), (-1.0, second)):  # motor 1 pulls at the toe
        centre = np.array([side * (1 + _GAP) * radius, 0.0])
        axes.add_patch(Circle(tuple(centre), radius, facecolor="white", edgecolor=DARK, zorder=5))
        for angle, colour in ((0.0, LIGHT), (turn, MIDDLE)):
            # Cables run between the drums: where both go down, these turn towards each other.
            tip = centre + radius * np.array([-side * np.sin(angle), np.cos(angle)])
            axes.plot(*np.stack([centre, tip], 1), color=colour, linewidth=1.2, zorder=6)
    axes.set_xlabel(f"motors {first:+.1f},\n{second:+.1f} rad")
    geometry = library.robot.geometry
    bottom = geometry.leg_length + _SHARE * library.robot.joints["slide"].upper
    axes.set(xlim=(-0.13, 0.13), aspect="equal", xticks=[], yticks=[])
    axes.set_ylim(-bottom - 2 * geometry.ankle_height - 0.03, geometry.upper_foot_height + 0.1)
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)


def _leg(axes: Axes, library: GaitLibrary, joints: tuple[float, float], colour: str) -> None:
    geometry, capstan = library.robot.geometry, library.robot.capstan
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


def _angles(axes: Axes, library: GaitLibrary, drive: Transmission) -> None:
    """Lines of constant slide and of constant ankle angle over both motor angles."""
    slide, ankle = (library.robot.joints[name] for name in ("slide", "ankle"))
    at = partial(angles_of, drive)
    for value in np.linspace(slide.lower, slide.upper, 5):
        line = at(np.full(2, value), np.array([ankle.lower, ankle.upper]))
        axes.plot(*line.T, color=DARK)
        axes.annotate(f"{value:g} m ", line[0], ha="right", fontsize=6.5, color=DARK)
    for value in np.linspace(ankle.lower, ankle.upper, 3):
        line = at(np.array([slide.lower, slide.upper]), np.full(2, value))
        axes.plot(*line.T, color=MIDDLE, linestyle="--")
        text = f" {value:.2g} rad"
        axes.annotate(text, line[1], va="bottom", fontsize=6.5, color=MIDDLE)
    axes.set(title="slide and ankle", xlabel="motor 1 [rad]", ylabel="motor 2 [rad]")
    axes.set_aspect("equal")
    axes.margins(0.12)


def _efforts(axes: Axes, drive: Transmission) -> None:
    fastest = no_load(drive, SLIDE)
    for share, colour, dash in zip(_SPEEDS, _LINES, _DASHES, strict=True):
        region = effort_region(drive, share * fastest)
        label = f"{share * fastest:.3g} m/s"
        axes.plot(*region.T, color=colour, linestyle=dash, label=label)
    axes.set(title="force and torque", xlabel="slide force [N]", ylabel="ankle torque [N m]")
    look = {"columnspacing": 0.8, "handlelength": 1.2, "borderpad": 0.0, "fontsize": 6.5}
    axes.legend(loc="upper center", ncols=3, **look)
    axes.margins(y=0.22)


def _limits(axes: Axes, library: GaitLibrary, drive: Transmission, joint: int) -> None:
    fastest = no_load(drive, joint)
    speeds = np.linspace(-fastest, fastest, 201)
    low, high = effort_limits(drive, joint, speeds)
    axes.fill_between(speeds, low, high, facecolor=EMPTY, edgecolor=DARK, linewidth=0.8)
    gait = int(forward_gaits(library, 2)[-1])
    velocity = library.arrays["samples"][gait][:, NUM_JOINTS : 2 * NUM_JOINTS]
    effort = library.arrays["efforts"][gait]
    step = NUM_JOINTS // len(SIDES)
    for column in (joint, joint + step):
        axes.plot(velocity[:, column], effort[:, column], ".", color=MIDDLE, markersize=2.5)
    name, units = ("slide", ("m/s", "N")) if joint == SLIDE else ("ankle", ("rad/s", "N m"))
    axes.set(title=name, xlabel=f"speed [{units[0]}]", ylabel=f"effort [{units[1]}]")


def no_load(drive: Transmission, joint: int) -> float:
    """Speed of a joint at which its motors make no torque, the other joint at rest."""
    return float(drive.speed[_MOTORS[0]] / drive.matrix[_MOTORS[0], joint])
