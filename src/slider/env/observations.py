"""Observation terms: pure functions of a view, each declared with its units and its reflection.

The docstring of a term is its ``meaning`` in the layout of an exported policy, read by users who
have a robot but not this package.
"""

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from slider.config.env import ObservationConfig
from slider.config.robot import Geometry
from slider.core.arrays import Array, asarray, namespace
from slider.env.declaration import Function, Needs, Term, check_names, register
from slider.env.state import View
from slider.robot.kinematics import turn_to_heading
from slider.robot.names import (
    MIRROR_PERMUTATION,
    NUM_JOINTS,
    channel_units,
    joint_names,
    mirror_sign,
)

Frame = Literal["base", "heading", "world", "none"]
Names = tuple[str, ...] | Callable[[Geometry], tuple[str, ...]]
VELOCITY_ERROR_RANGE = 0.2  # [m/s]


@dataclass(frozen=True)
class Mirror:
    """Reflection in the sagittal plane: reflected = value[permutation] · sign."""

    permutation: tuple[int, ...]
    sign: tuple[float, ...]


def _in_place(*sign: float) -> Mirror:
    """Mirror that changes signs without permuting values."""
    return Mirror(tuple(range(len(sign))), sign)


_XYZ = ("x", "y", "z")
_POLAR = _in_place(1.0, -1.0, 1.0)  # vectors: y flips
_AXIAL = _in_place(-1.0, 1.0, -1.0)  # angular velocities: x and z flip
_LEVEL = _in_place(1.0, -1.0)  # forward and leftward


def _legs(_: ObservationConfig, geometry: Geometry) -> Mirror:
    return Mirror(MIRROR_PERMUTATION, mirror_sign(geometry))


@dataclass(frozen=True)
class Observation(Term):
    """A term of the observation: a function of a view, (N, width).

    Attributes:
        components: name of each value, in order; empty for a grid; joint names for joints.
        units: unit of each value before scaling; one for all, or one each.
        frame: base (moves with the trunk), heading (turned by the yaw only), world or none.
        mirror: its reflection, of the term's width, or a function that returns it.
    """

    components: Names
    units: str | Names
    frame: Frame
    mirror: Mirror | Callable[[ObservationConfig, Geometry], Mirror]

    @property
    def meaning(self) -> str:
        """How to compute the values: the docstring on one line."""
        return " ".join((inspect.getdoc(self.function) or "").split())

    def describe(self, width: int, geometry: Geometry) -> dict[str, Any]:
        """Units of all its ``width`` values, frame, components and meaning, as plain values."""
        units, components = (
            value(geometry) if callable(value) else value for value in (self.units, self.components)
        )
        return {
            "units": np.broadcast_to(units, width).tolist(),
            "frame": self.frame,
            "components": list(components),
            "meaning": self.meaning,
        }


TERMS: dict[str, Observation] = {}


def observation(
    components: Names,
    units: str | Names,
    frame: Frame,
    mirror: Mirror | Callable[[ObservationConfig, Geometry], Mirror],
    needs: Needs = Needs.NOTHING,
) -> Callable[[Function], Function]:
    """Declare an observation term; the arguments are those of :class:`Observation`."""
    return lambda function: register(
        TERMS, Observation(function, needs, components, units, frame, mirror)
    )


@observation(_XYZ, "m/s", "base", _POLAR)
def base_linear_velocity(view: View) -> Array:
    """Linear velocity of the base's origin, in the base frame."""
    return view.state.linear_velocity


@observation(("vx", "vy", "0"), "m/s", "heading", _POLAR)
def target_linear_velocity(view: View) -> Array:
    """Commanded velocity vx, vy, then 0."""
    velocity = view.command[:, :2]
    return _side_by_side(velocity, 0.0 * velocity[:, :1])


@observation(_XYZ, "rad/s", "base", _AXIAL)
def base_angular_velocity(view: View) -> Array:
    """Angular velocity of the base, in the base frame (gyroscope)."""
    return view.state.angular_velocity


@observation(("0", "0", "yaw_rate"), "rad/s", "base", _AXIAL)
def target_angular_velocity(view: View) -> Array:
    """0, 0 and the commanded yaw rate."""
    return _side_by_side(0.0 * view.command[:, :2], view.command[:, 2:3])


@observation(_XYZ, "-", "base", _POLAR)
def projected_gravity(view: View) -> Array:
    """Unit vector of gravity in the base frame: (0, 0, -1) when upright."""
    return view.state.gravity


@observation(
    ("vx", "vy", "yaw_rate", "heading_error"),
    ("m/s", "m/s", "rad/s", "rad"),
    "heading",
    _in_place(1.0, -1.0, -1.0, -1.0),
)
def command(view: View) -> Array:
    """Commanded velocity; heading_error = (target - yaw) wrapped to [-pi, pi).

    The target is the yaw at the start; each later control step adds yaw_rate times control_period.
    """
    return view.command


@observation(joint_names, lambda geometry: channel_units(geometry)[:NUM_JOINTS], "none", _legs)
def joint_positions(view: View) -> Array:
    """Joint position minus joints[i].default."""
    return view.state.joint_positions - view.nominal


@observation(
    joint_names,
    lambda geometry: channel_units(geometry)[NUM_JOINTS : 2 * NUM_JOINTS],
    "none",
    _legs,
)
def joint_velocities(view: View) -> Array:
    """Joint velocity."""
    return view.state.joint_velocities


@observation(joint_names, "-", "none", _legs)
def previous_action(view: View) -> Array:
    """The last action, clipped and mirrored back; 0 at the start and where action.scale is 0."""
    return view.action


@observation(joint_names, "-", "none", _legs)
def action_before_previous(view: View) -> Array:
    """The action before previous_action, in the same form.

    With an input delay the motors may not have received it yet.
    """
    return view.previous_action


@observation(("z",), "m", "world", _in_place(1.0))
def base_height(view: View) -> Array:
    """Height of the base's origin above the ground under the feet minus simulation.base_height."""
    return view.state.base_height[:, None] - view.nominal_height


@observation(("forward", "leftward"), "m/s", "heading", _LEVEL)
def filtered_velocity(view: View) -> Array:
    """Low-pass filtered velocity f of the base, rotated by minus the yaw; f = 0 at the start.

    Each later control step: f += g (v - f), g = control_period / max(control_period, T), with the
    unfiltered velocity v and the training's T = env.observation.velocity_filter.
    """
    return view.filtered_velocity


@observation(("vx", "vy"), "m/s", "heading", _LEVEL)
def reference_velocity(view: View) -> Array:
    """Commanded velocity, rate limited by the training's env.reference.acceleration (0: none)."""
    return view.reference_velocity


@observation(("forward", "leftward"), "-", "heading", _LEVEL)
def velocity_error(view: View) -> Array:
    """tanh((filtered_velocity - expected) / (0.2 m/s)).

    expected is reference_velocity, filtered like filtered_velocity from 0 at the start. The term is
    almost redundant, but networks are slow to learn small differences of large inputs.
    """
    error = view.filtered_velocity - view.expected_velocity
    return (error / VELOCITY_ERROR_RANGE).tanh()


@observation(("sin", "cos"), "-", "none", _in_place(-1.0, -1.0), Needs.CLOCK)
def phase(view: View) -> Array:
    """Sine and cosine of 2 pi times the phase of the gait clock; 0, 0 while the clock is halted."""
    angle = 2.0 * np.pi * view.phase  # half a walk later the other leg is in stance: signs flip
    return _side_by_side(angle.sin()[:, None], angle.cos()[:, None]) * ~view.halted[:, None]


def _mirrored_grid(config: ObservationConfig, _: Geometry) -> Mirror:
    nx, ny = config.height_scan.points_x, config.height_scan.points_y
    reflected = np.arange(nx * ny).reshape(nx, ny)[:, ::-1].ravel()
    return Mirror(tuple(reflected.tolist()), (1.0,) * (nx * ny))


@observation((), "m", "heading", _mirrored_grid)
def height_scan(view: View) -> Array:
    """Height of the base's origin above points of a grid around it; see height_scan.

    Rows go from back to front, the points of a row from right to left.
    """
    state, counts = view.state, (view.scan.points_x, view.scan.points_y)
    ground = state.ground if state.scanned is None else state.scanned
    if ground.flat:
        return state.base_position[:, 2:3].expand(-1, math.prod(counts))
    grid = [view.scan.spacing * (np.arange(n) - 0.5 * (n - 1)) for n in counts]
    x, y = (values.ravel() for values in np.meshgrid(*grid, indexing="ij"))
    grid = asarray(np.stack([x, y], axis=-1), state.yaw)
    points = turn_to_heading(grid, -state.yaw[:, None]) + state.base_position[:, None, :2]
    return state.base_position[:, 2:3] - ground.height(points)


class Observer:
    """Concatenates the configured terms: scaled, reflected for some robots, clipped.

    Attributes:
        layout: name → width of the terms, in order; ``size`` is their sum.
        permutation, sign: reflected observation = observation[permutation] · sign, (size,).
    """

    def __init__(self, config: ObservationConfig, geometry: Geometry) -> None:
        check_names(TERMS, config.terms, "env.observation.terms")
        self._clip = config.clip
        self._terms = [(TERMS[name].function, scale) for name, scale in config.terms.items()]
        self.layout, permutations, signs, self.size = {}, [], [], 0
        for name in config.terms:
            mirror = TERMS[name].mirror
            mirror = mirror if isinstance(mirror, Mirror) else mirror(config, geometry)
            permutations.append(self.size + np.array(mirror.permutation))
            signs.append(mirror.sign)
            self.layout[name] = len(mirror.sign)
            self.size += len(mirror.sign)
        self.permutation, self.sign = np.concatenate(permutations), np.concatenate(signs)

    def __call__(self, view: View, mirrored: Array) -> Array:
        """Observations (N, size) float32; those of ``mirrored`` (N,) robots are reflected."""
        parts = [function(view) * scale for function, scale in self._terms]
        values = reflect(_side_by_side(*parts), mirrored, self.permutation, self.sign)
        return values.clip(-self._clip, self._clip).float()


def _side_by_side(*parts: Array) -> Array:
    return namespace(parts[0]).concat(parts, dim=1)


def reflected(values: Array, permutation: Any, sign: Any) -> Array:
    """Reflection of values (N, K): values[permutation] · sign."""
    return values[:, permutation] * asarray(sign, values)


def reflect(values: Array, mirrored: Array, permutation: np.ndarray, sign: np.ndarray) -> Array:
    """Values (N, K), with those of ``mirrored`` (N,) robots reflected."""
    return reflected(values, permutation, sign).where(mirrored[:, None], values)
