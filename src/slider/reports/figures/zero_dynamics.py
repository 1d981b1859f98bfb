"""The zero dynamics manifold and the impact surface, in knee and in slide coordinates.

The paper's figure "Transformation of Zero Dynamic space", of a gait of the library. The walk is
one domain: at touchdown the legs are swapped and reflected at the sagittal plane.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.axes3d import Axes3D

from slider.library.blend import Gait, blend
from slider.library.reader import GaitLibrary
from slider.reports.figures.cycles import forward_gaits
from slider.reports.figures.style import DARK, LIGHT, MIDDLE, new_figure
from slider.robot.kinematics import about_x, foot_ends, leg_points
from slider.robot.names import joint_names, knee_joint_names

_PHASE = np.linspace(0.0, 1.0, 101)
_ROLLS = 41
_TOUCHDOWNS = np.linspace(0.5, 1.05, 221)  # phases at which the swing foot may land
_CAPTION = """\
The gait at ({vx:g}, {vy:g}) m/s. Axes are the roll of the stance foot, which no motor drives, and
position and velocity of a joint of the swing leg; eq. 1 maps the virtual knee to the slide. Z: all
joints are on their virtual constraints, whatever the roll; its rate is not drawn. S: the swing foot
touches the ground; contact depends on positions alone, so S is upright. The orbit crosses S ∩ Z,
and the impact Δ takes it to the start of the next step, where the legs have changed names. Z ends
at the touchdown; where that is later than the gait's, the joints' polynomials go on.
"""
_MARGIN = 0.35  # of the drawn roll beyond the gait's, as a share of its range


@dataclass(frozen=True)
class Portrait:
    """A step in the space of a joint's position, its velocity and the stance foot's roll.

    Attributes:
        orbit: (3, N) the gait, from just after an impact to just before the next.
        manifold: (3, R, N) states on the virtual constraints, Z, by roll and phase. Where the swing
            foot touches down within ``_TOUCHDOWNS``, the last state is the one then, on S ∩ Z.
        landed: (R,) where it does; elsewhere Z ends at the phase of the nearest roll that does.
        image: (3,) the gait just after the impact, Δ(S ∩ Z).
    """

    orbit: np.ndarray
    manifold: np.ndarray
    landed: np.ndarray
    image: np.ndarray


def draw(library: GaitLibrary) -> Figure:
    """Virtual knee on the left, slide on the right; without a virtual knee the leg's own joint."""
    robot, gait = library.robot, _shown(library)
    figure = new_figure(3.4)
    figure.set_layout_engine(None)  # which ignores the labels of 3-D axes
    slides = robot.geometry.knee is None
    panels = [("right_slide", *(("prismatic joint", "m") if slides else ("knee", "rad")))]
    if robot.virtual_knee is not None:
        panels.insert(0, ("right_knee", "virtual knee", "rad"))
    for place, (joint, title, unit) in enumerate(panels):  # of the swing leg
        bounds = (0.5 * place - 0.01 + 0.25 * (len(panels) == 1), 0.0, 0.47, 1.0)
        # In the order of drawing: the orbit in front of the surfaces.
        axes = figure.add_axes(bounds, projection="3d", computed_zorder=False)
        assert isinstance(axes, Axes3D)
        _draw(axes, portrait(gait, joint))
        axes.set_title(title, y=0.96)
        axes.set_xlabel("roll of the stance foot [rad]", labelpad=-3)
        axes.set_ylabel(f"position [{unit}]", labelpad=-3)
        axes.set_zlabel(f"velocity [{unit}/s]", labelpad=-3)
    return figure


def caption(library: GaitLibrary) -> str:
    """What the surfaces are, and of which gait."""
    vx, vy, _ = _shown(library).velocity
    return _CAPTION.format(vx=vx, vy=vy)


def portrait(gait: Gait, joint: str) -> Portrait:
    """States of the first step of a gait, for a joint of one of the two models."""
    low, high = gait.roll[0, :, 0].min(), gait.roll[0, :, 0].max()
    margin = _MARGIN * max(high - low, 1e-3)
    roll = np.linspace(low - margin, high + margin, _ROLLS)
    nodes = np.linspace(0.0, 1.0, gait.roll.shape[1])
    orbit = np.stack([np.interp(_PHASE, nodes, gait.roll[0, :, 0]), *_joint(gait, joint, _PHASE)])
    end = touchdown(gait, roll)
    landed = np.isfinite(end)
    if landed.any():  # elsewhere Z ends with its neighbours
        end = np.interp(roll, roll[landed], end[landed])
    phase = np.where(np.isfinite(end), end, 1.0)[:, None] * _PHASE
    sheet = np.stack(np.broadcast_arrays(roll[:, None], *_joint(gait, joint, phase)))
    # The swing leg of the second step is the left one.
    position, velocity = _joint(gait, joint.replace("right", "left"), np.zeros(1), step=1)
    image = np.array([gait.roll[1, 0, 0], position[0], velocity[0]])
    return Portrait(orbit, sheet, landed, image)


def touchdown(gait: Gait, roll: np.ndarray) -> np.ndarray:
    """Phase (R,) of touchdown of the swing foot at each roll (R,) [rad]; NaN without one."""
    phase = np.full(len(roll), np.nan)
    for index, angle in enumerate(roll):
        height = swing_height(gait, angle, _TOUCHDOWNS)
        down = np.flatnonzero((height[:-1] > 0) & (height[1:] <= 0))
        if len(down):
            at = slice(down[0], down[0] + 2)
            phase[index] = np.interp(0.0, -height[at], _TOUCHDOWNS[at])
    return phase


def swing_height(gait: Gait, roll: float, phase: np.ndarray) -> np.ndarray:
    """Lowest point of the swing foot above the stance foot's (N,) [m], at a roll, at phases (N,).

    Joints are on their constraints; the stance foot is the left one, flat up to its roll.
    """
    geometry, joints = gait.library.robot.geometry, gait.joints(0, phase)[0]
    level = np.broadcast_to(np.eye(3), (len(phase), 3, 3))
    hip, ankle = leg_points(geometry, level, joints)[:, 0, :2].swapaxes(0, 1)
    heel, toe = foot_ends(geometry, level, joints)[:, 0].swapaxes(0, 1)
    forward, up = _unit(toe - heel), _unit(hip - ankle)
    left = _unit(np.cross(up, forward))  # the ankle turns about it
    foot = np.stack([forward, left, np.cross(forward, left)], axis=1)  # base to foot
    ends = foot_ends(geometry, about_x(np.array([roll])) @ foot, joints)[..., 2].min(axis=2)
    return ends[:, 1] - ends[:, 0]


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _shown(library: GaitLibrary) -> Gait:
    """The gait straight ahead in the middle of the library's speeds."""
    chosen = forward_gaits(library, 3)
    return blend(library, *library.velocities[chosen[len(chosen) // 2]])


def _joint(
    gait: Gait, joint: str, phase: np.ndarray, step: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity (...) of a joint of the knee or of the prismatic robot, at phases."""
    flat, geometry = phase.ravel(), gait.library.robot.geometry
    names, values = knee_joint_names(geometry), gait.knee_joints(step, flat)
    if joint not in names:
        names, values = joint_names(geometry), gait.joints(step, flat)
    position, velocity = (value[:, names.index(joint)].reshape(phase.shape) for value in values)
    return position, velocity


def _draw(axes: Axes3D, shown: Portrait) -> None:
    low, high = shown.manifold[2].min(), shown.manifold[2].max()
    edge = shown.manifold[:, shown.landed, -1]
    axes.plot_surface(*shown.manifold, color=LIGHT, alpha=0.35, linewidth=0)
    if edge.size:
        x, y = (np.broadcast_to(value, (2, len(value))) for value in edge[:2])
        z = np.broadcast_to([[low], [high]], x.shape)
        axes.plot_surface(x, y, z, color=MIDDLE, alpha=0.22, linewidth=0)
        axes.plot(*edge, color=MIDDLE)
        axes.text(edge[0, -1], edge[1, -1], low, "  S", color=MIDDLE)
    axes.plot(*shown.orbit, color=DARK)
    jump = np.stack([shown.orbit[:, -1], shown.image], axis=1)
    axes.plot(*jump, ":", color=DARK)
    axes.plot(*jump[:, :1], "o", color=DARK, markersize=3.5)
    axes.plot(*jump[:, 1:], "o", color=DARK, markerfacecolor="white", markersize=3.5)
    middle = shown.manifold[:, -1, len(_PHASE) // 2]
    for place, text in ((jump[:, 0], "S ∩ Z"), (jump[:, 1], "Δ(S ∩ Z)"), (middle, "Z")):
        axes.text(place[0], place[1], place[2], f"  {text}", color=DARK)
    axes.view_init(20, -58)
    axes.set_box_aspect((1.3, 1, 1), zoom=0.94)  # pyright: ignore[reportArgumentType]
    axes.locator_params(nbins=4)
    axes.tick_params(labelsize=6.5, pad=-1)
