"""Coordinates of the virtual constraints in single support, and how the ground changes them.

All is in the frame of the stance foot, reflected in right stance. ``stance`` (n,) are the feet.
"""

from dataclasses import dataclass

import numpy as np

from slider.control.whole_body.memory import RIGHT, Memory
from slider.control.whole_body.model import NUM_DOFS, Dynamics
from slider.control.whole_body.tasks import pitch_and_yaw, point_velocity, wrapped
from slider.gait.outputs import (
    ANKLE,
    JOINTS,
    LEG,
    NUM_COORDINATES,
    ROLL,
    STANCE,
    SWING,
    YAW,
    stance_first,
    stance_selection,
)
from slider.hzd.constraints import Orders, smooth_step
from slider.robot.kinematics import turn_to_heading, yaw_of
from slider.robot.names import GAIT_JOINTS, LAST_JOINTS

_DRIVEN = np.array(GAIT_JOINTS)


@dataclass(frozen=True)
class ControlledCoordinates:
    """Coordinates of n robots in stance: roll, yaw and driven joints, stance leg first.

    Attributes:
        x, rate: (n, 12).
        jacobian: (n, 12, 18), ẍ = jacobian q̈ + terms in q̇.
    """

    x: np.ndarray
    rate: np.ndarray
    jacobian: np.ndarray


def side_of(stance: np.ndarray) -> np.ndarray:
    """+1 in left stance, −1 in right stance (n,)."""
    return np.where(stance == RIGHT, -1.0, 1.0)


def controlled_coordinates(
    dynamics: Dynamics,
    stance: np.ndarray,
    heading: np.ndarray,
    yaw_rate: np.ndarray,
    signs: np.ndarray,
    soles: bool = False,
) -> ControlledCoordinates:
    """Coordinates; yaw is relative to ``heading`` (n,) [rad], which turns at ``yaw_rate`` (n,).

    ``signs`` (10,) reflect the driven joints. With ``soles``, roll is the leg's, not the foot's.
    """
    rows, right, side = np.arange(len(stance)), stance == RIGHT, side_of(stance)
    rotation = dynamics.foot_rotations[rows, stance]
    angular = dynamics.foot_jacobians[rows, stance, 3:]
    axes = np.stack([rotation[:, :, 0], pitch_and_yaw(rotation)[:, 1]], axis=1)
    jacobian = np.zeros((len(stance), NUM_COORDINATES, NUM_DOFS))
    jacobian[:, JOINTS:, 6:] = stance_selection(right, signs)
    np.multiply(side[:, None, None], axes @ angular, out=jacobian[:, :JOINTS])
    roll = np.arcsin(np.clip(rotation[:, 2, 1], -1.0, 1.0))
    if soles:  # on which the legs roll
        last = np.array(LAST_JOINTS)[stance]
        roll = roll - dynamics.joints[rows, last]
        jacobian[rows, ROLL, 6 + last] -= side
    roll = side * roll
    yaw = side * wrapped(yaw_of(rotation) - heading)
    joints = stance_first(dynamics.joints[:, _DRIVEN], right, signs)
    rate = point_velocity(jacobian, dynamics.qvel)
    rate[:, YAW] -= side * yaw_rate
    x = np.concatenate([roll[:, None], yaw[:, None], joints], axis=1)
    return ControlledCoordinates(x, rate, jacobian)


def hip(dynamics: Dynamics, stance: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position (n,) [m] and velocity [m/s] of the base along a foot line of yaw ``line`` (n,)."""
    sole = dynamics.foot_positions[np.arange(len(stance)), stance, :2]
    position = turn_to_heading(dynamics.base_position[:, :2] - sole, line)[:, 0]
    return position, turn_to_heading(dynamics.qvel[:, :2], line)[:, 0]


def com_state(dynamics: Dynamics, stance: np.ndarray) -> np.ndarray:
    """ξ = (c_y, ċ_y, ċ_x, c_x) (n, 4) of the centre of mass, from the stance sole [m], [m/s]."""
    rows = np.arange(len(stance))
    yaw = yaw_of(dynamics.foot_rotations[rows, stance])
    position = dynamics.com[:, :2] - dynamics.foot_positions[rows, stance, :2]
    position, speed = (turn_to_heading(v, yaw) for v in (position, dynamics.com_velocity[:, :2]))
    side = side_of(stance)
    lateral = [side * position[:, 1], side * speed[:, 1]]
    return np.stack([*lateral, speed[:, 0], position[:, 0]], axis=1)


def terrain_motion(
    memory: Memory,
    robots: np.ndarray,
    footholds: np.ndarray,
    phase: np.ndarray,
    extension: np.ndarray,
    level: float,
) -> Orders:
    """Change of coordinates (n, 12) with two derivatives over the phase (n,); zeros where level.

    Gaits are those of level ground. As in :func:`slider.env.height_field.adapt_to_terrain`, the
    base height is relative to the mean ground under both feet, and ankles are turned by its slope.
    With h the height of the swing foot's ground above the stance foot's, the stance leg is longer
    and the swing leg shorter by h/2. The centre of mass then moves parallel to the line through the
    footholds, where the linear pendulum moves as on level ground (Kajita et al., "The 3D linear
    inverted pendulum mode", IROS 2001).

    Args:
        memory, robots: memory with the ground; indices (n,).
        footholds: of the stance foot, of the swing foot's last and next stance (n, 3, 2) [m].
        phase: of the steps (n,).
        extension: joints of the stance and the swing leg per length (2, 5).
        level: angle of an ankle per pitch of its foot.
    """
    ground = memory.ground.of(robots)
    height, slope = ground.height(footholds, gaps=False), ground.gradient(footholds)
    _, last, following = (height - height[:, :1]).T
    steep = turn_to_heading(slope, memory.heading[robots, None])[..., 0]
    under, before, after = level * np.arctan(steep).T
    rise, turn = following - last, after - before
    middle = last + rise * phase, rise, np.zeros_like(rise)
    orders = np.zeros((3, len(phase), NUM_COORDINATES))
    stance, swing = (slice(first, first + LEG) for first in (STANCE, SWING))
    for order, (lift, share) in enumerate(zip(middle, smooth_step(phase), strict=True)):
        orders[order][:, stance] = (lift / 2)[:, None] * extension[0]
        orders[order][:, swing] = (lift / 2 - rise * share)[:, None] * extension[1]
        orders[order, :, SWING + ANKLE] -= turn * share
    orders[0][:, swing] -= last[:, None] * extension[1]
    orders[0, :, SWING + ANKLE] -= before
    orders[0, :, STANCE + ANKLE] -= under
    return orders[0], orders[1], orders[2]
