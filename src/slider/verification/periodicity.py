"""Check 3: the walk comes back to where it began, at the commanded mean velocity."""

import numpy as np
from scipy.spatial.transform import Rotation

from slider.verification.stored import StoredGait


def mean_velocity(gait: StoredGait) -> dict[str, float]:
    """Displacement of the base over the walk, and the feet's, against the command [m/s].

    The last sample is the first one of the next walk, but for its velocities.
    """
    walk = gait.step_time.sum()
    travelled = [gait.base[-1, :2] - gait.base[0, :2]]
    travelled.append(gait.swing_foot[gait.half - 1, :2] + gait.swing_foot[-1, :2])
    errors = [np.abs(way / walk - gait.velocities).max() for way in travelled]
    return {"mean_velocity": float(max(errors))}


def periodicity(gait: StoredGait) -> dict[str, float]:
    """Jump of joints [rad], base height [m] and base orientation [rad] over both touchdowns.

    Velocities jump; by how much is the impact's check.
    """
    ends = [gait.half - 1, 2 * gait.half - 1]
    starts = [gait.half, 0]
    joints = gait.knee_positions[ends] - gait.knee_positions[starts]
    height = gait.base[ends, 2] - gait.base[starts, 2]
    turn = _rotations(gait, ends) * _rotations(gait, starts).inv()
    middle = gait.base[gait.half - 1, :2] - gait.base[gait.half, :2]
    jumps = (joints, height, turn.magnitude(), middle)
    return {"periodicity": max(float(np.abs(jump).max()) for jump in jumps)}


def _rotations(gait: StoredGait, samples: list[int]) -> Rotation:
    return Rotation.from_quat(gait.base[samples, 3:7], scalar_first=True)
