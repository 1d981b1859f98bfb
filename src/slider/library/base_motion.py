"""Blending the motion of the base: position, quaternion, velocities.

Layout: ``docs/reference/gait-library.md``.
"""

import numpy as np

QUATERNION = slice(3, 7)


def aligned(base: np.ndarray) -> np.ndarray:
    """Base motion (..., 13) with quaternions on one half sphere, so that they may be blended."""
    result = base.copy()
    result[..., QUATERNION] *= np.where(base[..., 3:4] < 0, -1.0, 1.0)
    return result


def normalise(base: np.ndarray) -> np.ndarray:
    """Make the quaternions of blended motion (..., 13) unit again, in place; return it."""
    quaternion = base[..., QUATERNION]
    quaternion /= np.linalg.norm(quaternion, axis=-1, keepdims=True)
    return base
