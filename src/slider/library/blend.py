"""A gait at any velocity: blended Bézier coefficients (virtual constraints) of the gaits around it.

Joints come from the blended polynomials, so that velocities are the derivatives of positions. Roll
about the foot line, ankle rolls of feet with soles and motion of the base are interpolated at each
node. Between the gaits a blend satisfies dynamics and constraints only approximately, and it is not
a periodic orbit.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from slider.gait import bezier
from slider.library.mesh import aligned, normalise
from slider.library.reader import GaitLibrary
from slider.robot import knee_map
from slider.robot.names import LAST_JOINTS, NUM_JOINTS, velocity_text

_BLENDED = ("step_time", "coefficients", "roll")
_OUTSIDE = 1e-6  # [m/s]


@dataclass(frozen=True)
class Gait:
    """A walk of two steps, left stance first.

    Attributes:
        velocity: (3,) vx, vy [m/s], yaw rate [rad/s], within the library's range.
        weights: (G,) share of each gait of the library.
        step_time: (2,) duration of the steps [s].
        coefficients: (2, 10, degree + 1) Bézier coefficients [rad], as in the library.
        roll: (2, nodes, 3) roll of the stance foot about its line, its rate and acceleration.
        base: (2 · nodes, 13) motion of the base, as in the library.
        last: (2 · nodes, 2, 2) positions and velocities of the sixth joint of each leg
            (``upper_foot`` or ``ankle_roll``).
        forward, leftward: (2 · nodes,) speed of the base in its heading frame [m/s].
    """

    velocity: np.ndarray
    weights: np.ndarray
    step_time: np.ndarray
    coefficients: np.ndarray
    roll: np.ndarray
    base: np.ndarray
    last: np.ndarray
    forward: np.ndarray
    leftward: np.ndarray
    library: GaitLibrary

    def knee_joints(self, step: int, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Virtual-knee positions [rad] and velocities [rad/s] (N, 10), left leg then right leg.

        At phases (N,) in [0, 1] of step 0 in left stance or step 1 in right stance.
        """
        coefficients = self.coefficients[step]
        q = bezier.evaluate(coefficients, phase)
        v = bezier.evaluate(coefficients, phase, order=1) / self.step_time[step]
        if step == 0:
            return q, v
        geometry = self.library.robot.geometry
        return knee_map.reflected(q, geometry), knee_map.reflected(v, geometry)

    def joints(self, step: int, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities (N, 12) of the prismatic joints (eq. 1) at phases (N,)."""
        q, v = self.knee_joints(step, phase)
        joints = knee_map.prismatic_joints(q, v, self.library.robot, self.library.kinematic_map)
        last = np.split(self.last, 2)[step]
        nodes = np.linspace(0.0, 1.0, len(last))
        for order, values in enumerate(joints):
            for leg, joint in enumerate(LAST_JOINTS):
                values[:, joint] = np.interp(phase, nodes, last[:, order, leg])
        return joints

    def samples(self) -> np.ndarray:
        """The 26 channels (2 · nodes, 26) at the library's samples."""
        phase = np.linspace(0.0, 1.0, len(self.base) // 2)
        steps = [self.joints(step, phase) for step in range(2)]
        position, velocity = (np.concatenate(values) for values in zip(*steps, strict=True))
        speeds = np.stack([self.forward, self.leftward], axis=1)
        return np.concatenate([position, velocity, speeds], axis=1)


def blend(library: GaitLibrary, vx: float, vy: float, yaw_rate: float = 0.0) -> Gait:
    """Gait at a velocity [m/s, rad/s]: trilinear in the velocities around it, step times included.

    At a velocity of the library it is that gait. It is continuous in the velocity everywhere;
    the border and holes are as in ``slider.library.mesh``.

    Raises:
        ValueError: the velocity is not finite.
    """
    velocity = np.array([vx, vy, yaw_rate])
    if not np.isfinite(velocity).all():
        raise ValueError(f"expected a finite velocity, found {velocity_text(velocity)}")
    mesh, arrays = library.mesh, library.arrays
    weights = mesh.weights(velocity[None])[0]
    blended = {name: np.tensordot(weights, arrays[name], axes=1) for name in _BLENDED}
    base = normalise(np.tensordot(weights, aligned(arrays["base"]), axes=1))
    samples = np.tensordot(weights, arrays["samples"], axes=1)
    joints, speeds = np.split(samples, [2 * NUM_JOINTS], axis=1)
    return Gait(
        velocity=mesh.inside(velocity),
        weights=weights,
        base=base,
        last=joints.reshape(-1, 2, NUM_JOINTS)[..., LAST_JOINTS],
        forward=speeds[:, 0],
        leftward=speeds[:, 1],
        library=library,
        **blended,
    )


class GaitStatistics(NamedTuple):
    """Touchdowns of both feet [1/s], and variance of the forward velocity over time [m²/s²]."""

    touchdown_rate: float
    velocity_variance: float


def gait_statistics(library: GaitLibrary, vx: float) -> GaitStatistics | None:
    """Statistics of the blended gait at (vx, 0) [m/s]; None outside the library's range.

    For comparison, not a bound: the gaits are not optimised for a constant speed.
    """
    axis = library.mesh.vx
    if not axis[0] - _OUTSIDE <= vx <= axis[-1] + _OUTSIDE:
        return None
    gait = blend(library, vx, 0.0)
    speed = gait.forward.reshape(2, -1)
    share = gait.step_time / gait.step_time.sum()
    mean = share @ _mean(speed)
    variance = float(share @ _mean((speed - mean) ** 2))
    return GaitStatistics(float(1.0 / gait.step_time.mean()), variance)


def _mean(steps: np.ndarray) -> np.ndarray:
    """Trapezoidal mean over each step (2,) of samples (2, nodes) evenly spaced in time."""
    return np.trapezoid(steps, dx=1.0 / (steps.shape[1] - 1), axis=1)
