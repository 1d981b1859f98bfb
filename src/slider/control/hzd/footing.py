"""What the ground under the footholds of a step changes of the gaits' coordinates.

Gaits are those of level ground. As in :func:`slider.env.ground.fitted`, the base counts from the
mean of the ground under both feet, and ankles are turned by its slope. With h the height of the
swing foot's ground over the stance foot's, the stance leg is longer by h/2, the swing leg shorter.
The centre of mass then goes parallel to the line through the footholds, where the linear pendulum
moves as on level ground (Kajita et al., "The 3D linear inverted pendulum mode", IROS 2001).
"""

import numpy as np

from slider.control.whole_body.memory import Memory
from slider.gait.outputs import ANKLE, NUM_COORDINATES, STANCE, SWING
from slider.hzd.constraints import Orders, smooth_step
from slider.robot.kinematics import turn_to_heading

SLIDE = 3  # place of the slide in a leg


def uneven(memory: Memory, robots: np.ndarray, footholds: np.ndarray, phase: np.ndarray) -> Orders:
    """Change of coordinates (n, 12) with two derivatives over the phase (n,); zeros where level.

    ``footholds`` (n, 3, 2) [m]: of the stance foot, of the swing foot's last and next stance.
    """
    ground = memory.ground.of(robots)
    height, slope = ground.height(footholds, gaps=False), ground.gradient(footholds)
    _, last, following = (height - height[:, :1]).T
    steep = turn_to_heading(slope, memory.heading[robots, None])[..., 0]
    under, before, after = np.arctan(steep).T
    rise, turn = following - last, after - before
    middle = last + rise * phase, rise, np.zeros_like(rise)
    orders = np.zeros((3, len(phase), NUM_COORDINATES))
    for order, (lift, share) in enumerate(zip(middle, smooth_step(phase), strict=True)):
        orders[order, :, STANCE + SLIDE] = lift / 2
        orders[order, :, SWING + SLIDE] = lift / 2 - rise * share
        orders[order, :, SWING + ANKLE] = -turn * share
    orders[0, :, SWING + SLIDE] -= last
    orders[0, :, SWING + ANKLE] -= before
    orders[0, :, STANCE + ANKLE] = -under
    return orders[0], orders[1], orders[2]
