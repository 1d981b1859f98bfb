"""Observation terms: pure functions of a view, each with its reflection at the sagittal plane."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slider.config.env import ObservationConfig
from slider.core.errors import UserError
from slider.env.view import View
from slider.robot.kinematics import turn_to_heading
from slider.robot.names import MIRROR_PERMUTATION, MIRROR_SIGN

VELOCITY_ERROR_RANGE = 0.2  # [m/s]
_POLAR = (1.0, -1.0, 1.0)  # vectors: y flips
_AXIAL = (-1.0, 1.0, -1.0)  # angular velocities: x and z flip


def base_linear_velocity(view: View) -> np.ndarray:
    """Base velocity in the base frame (N, 3) [m/s]."""
    return view.state.linear_velocity


def target_linear_velocity(view: View) -> np.ndarray:
    """Commanded vx, vy and 0 (N, 3) [m/s]."""
    return np.pad(view.command[:, :2], ((0, 0), (0, 1)))


def base_angular_velocity(view: View) -> np.ndarray:
    """Angular velocity in the base frame (N, 3) [rad/s]."""
    return view.state.angular_velocity


def target_angular_velocity(view: View) -> np.ndarray:
    """0, 0 and the commanded yaw rate (N, 3) [rad/s]."""
    return np.pad(view.command[:, 2:3], ((0, 0), (2, 0)))


def projected_gravity(view: View) -> np.ndarray:
    """Direction of gravity in the base frame (N, 3)."""
    return view.state.gravity


def command(view: View) -> np.ndarray:
    """vx, vy [m/s], yaw rate [rad/s], heading error [rad] (N, 4)."""
    return view.command


def joint_positions(view: View) -> np.ndarray:
    """Joint positions about the nominal pose (N, 12) [rad or m]."""
    return view.state.joint_positions - view.nominal


def joint_velocities(view: View) -> np.ndarray:
    """Joint velocities (N, 12) [rad/s or m/s]."""
    return view.state.joint_velocities


def previous_action(view: View) -> np.ndarray:
    """The last action (N, 12)."""
    return view.action


def action_before_previous(view: View) -> np.ndarray:
    """The action before the last (N, 12): with a delay it may still be on its way."""
    return view.previous_action


def base_height(view: View) -> np.ndarray:
    """Base height above the ground about the nominal height (N, 1) [m]."""
    return view.state.base_height[:, None] - view.nominal_height


def filtered_velocity(view: View) -> np.ndarray:
    """Low-passed forward and leftward velocity (N, 2) [m/s]."""
    return view.filtered_velocity


def reference_velocity(view: View) -> np.ndarray:
    """Velocity on the way from one command to the next, forward and leftward (N, 2) [m/s]."""
    return view.reference_velocity


def velocity_error(view: View) -> np.ndarray:
    """tanh((low-passed velocity − low-passed reference)/0.2 m/s), forward and leftward (N, 2).

    Says little new, but in one number: networks find small differences of large inputs late.
    """
    return np.tanh((view.filtered_velocity - view.expected_velocity) / VELOCITY_ERROR_RANGE)


def phase(view: View) -> np.ndarray:
    """Sine and cosine of the clock (N, 2); zeros while it is halted."""
    angle = 2.0 * np.pi * view.phase
    return np.stack([np.sin(angle), np.cos(angle)], axis=1) * ~view.halted[:, None]


def height_scan(view: View) -> np.ndarray:
    """Base height above each point of a grid around the base (N, points) [m].

    The grid lies in the heading frame: from back to front, in each row from right to left.
    """
    state, (nx, ny) = view.state, view.scan_points
    if state.ground.flat:
        return np.repeat(state.base_position[:, 2:3], nx * ny, axis=1)
    grid = [view.scan_spacing * (np.arange(n) - 0.5 * (n - 1)) for n in (nx, ny)]
    x, y = (values.ravel() for values in np.meshgrid(*grid, indexing="ij"))
    points = turn_to_heading(np.stack([x, y], axis=-1), -state.yaw[:, None])
    points += state.base_position[:, None, :2]
    return state.base_position[:, 2:3] - state.ground.height(points)


@dataclass(frozen=True)
class Term:
    """An observation term and how it looks in a mirror.

    Attributes:
        function: view → (N, size).
        size: width of the term, or 0 when it follows from the height scan.
        permutation, sign: reflected = value[permutation] · sign.
    """

    function: Callable[[View], np.ndarray]
    size: int
    permutation: tuple[int, ...]
    sign: tuple[float, ...]


def _vector(function: Callable[[View], np.ndarray], sign: tuple[float, ...]) -> Term:
    return Term(function, len(sign), tuple(range(len(sign))), sign)


def _joints(function: Callable[[View], np.ndarray]) -> Term:
    return Term(function, len(MIRROR_SIGN), MIRROR_PERMUTATION, MIRROR_SIGN)


def _scan(config: ObservationConfig) -> Term:
    nx, ny = config.height_scan.points_x, config.height_scan.points_y
    reflected = np.arange(nx * ny).reshape(nx, ny)[:, ::-1].ravel()
    return Term(height_scan, nx * ny, tuple(reflected.tolist()), (1.0,) * (nx * ny))


TERMS = {
    "base_linear_velocity": _vector(base_linear_velocity, _POLAR),
    "target_linear_velocity": _vector(target_linear_velocity, _POLAR),
    "base_angular_velocity": _vector(base_angular_velocity, _AXIAL),
    "target_angular_velocity": _vector(target_angular_velocity, _AXIAL),
    "projected_gravity": _vector(projected_gravity, _POLAR),
    "command": _vector(command, (1.0, -1.0, -1.0, -1.0)),
    "joint_positions": _joints(joint_positions),
    "joint_velocities": _joints(joint_velocities),
    "previous_action": _joints(previous_action),
    "action_before_previous": _joints(action_before_previous),
    "base_height": _vector(base_height, (1.0,)),
    "filtered_velocity": _vector(filtered_velocity, (1.0, -1.0)),
    "reference_velocity": _vector(reference_velocity, (1.0, -1.0)),
    "velocity_error": _vector(velocity_error, (1.0, -1.0)),
    # Half a walk later the other leg is in stance.
    "phase": _vector(phase, (-1.0, -1.0)),
}


class Observer:
    """Concatenates the configured terms: scale, reflect where asked, clip.

    Attributes:
        layout: name → width of the terms, in order; ``size`` is their sum.
        permutation, sign: reflected observation = observation[permutation] · sign, (size,).
    """

    def __init__(self, config: ObservationConfig) -> None:
        known = {**TERMS, "height_scan": _scan(config)}
        unknown = [name for name in config.terms if name not in known]
        if unknown:
            raise UserError(
                f"env.observation.terms: expected some of {', '.join(known)}; found {unknown[0]}"
            )
        self._clip = config.clip
        self._terms = [(known[name], scale) for name, scale in config.terms.items()]
        self.layout = {name: known[name].size for name in config.terms}
        self.size = sum(self.layout.values())
        self.permutation = self._stack_permutations()
        self.sign = np.concatenate([term.sign for term, _ in self._terms])

    def _stack_permutations(self) -> np.ndarray:
        offsets = np.cumsum([0, *self.layout.values()])[:-1]
        pairs = zip(self._terms, offsets, strict=True)
        return np.concatenate([np.array(term.permutation) + offset for (term, _), offset in pairs])

    def __call__(self, view: View, mirrored: np.ndarray) -> np.ndarray:
        """Observations (N, size) float32; those of ``mirrored`` (N,) robots are reflected."""
        parts = [term.function(view) * scale for term, scale in self._terms]
        values = np.concatenate(parts, axis=1)
        values[mirrored] = values[mirrored][:, self.permutation] * self.sign
        return np.clip(values, -self._clip, self._clip).astype(np.float32)
