"""Robots that differ from the nominal one: masses, centre of mass, friction, motors."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Callable, Mapping

import mujoco
import numpy as np

from slider.config.env import DisturbanceConfig
from slider.config.types import Interval
from slider.core.arrays import Array, asarray, namespace, zeros
from slider.env.starts import NUMPY
from slider.robot import names

# Uniform numbers per robot: payload, one unused, delay, mass, friction, centre of mass, motors.
DELAY, COLUMNS = 2, 8  # and one per motor
VARIED_FIELDS = (
    *("body_mass", "body_inertia", "body_ipos", "geom_friction"),
    *("actuator_gainprm", "actuator_forcerange"),
)
"""Fields of MuJoCo's model that vary between robots."""
Fields = Mapping[str, Array]
# Indices of a DC motor's parameters: resistance, position gain and velocity gain.
_RESISTANCE, _GAINS = 0, [4, 6]


def vary(config: DisturbanceConfig) -> bool:
    """Whether robots differ from the nominal one."""
    fixed = config.mass == config.motor_gain == Interval(1.0, 1.0)
    loaded = config.payload.upper > 0
    return not fixed or loaded or config.centre_of_mass > 0 or config.friction is not None


class RandomizedRobots:
    """Robots randomised in each episode; arrays have the type and device of ``like``.

    ``write`` writes ``VARIED_FIELDS`` (n, ...), which differ from those of the ``nominal`` model,
    into the models of robots (n,).

    Attributes:
        motor_gain: (N, motors) factors on demanded torques [-].
    """

    def __init__(
        self,
        nominal: mujoco.MjModel,
        config: DisturbanceConfig,
        count: int,
        write: Callable[[Array, Fields], None],
        like: Array = NUMPY,
    ) -> None:
        self._config, self._write = config, write
        self._nominal = {name: asarray(getattr(nominal, name), like) for name in VARIED_FIELDS}
        self.motor_gain = zeros((count, nominal.nu), like) + 1.0
        feet = [nominal.body(names.foot(side)).id for side in names.SIDES]
        sliding = np.isin(nominal.geom_bodyid, feet)[:, None] & np.array([True, False, False])
        parameters = np.arange(nominal.actuator_gainprm.shape[1])
        masks = (
            np.arange(nominal.nbody) == nominal.body(names.BASE).id,
            sliding & (config.friction is not None),
            np.isin(parameters, _GAINS),
            parameters == _RESISTANCE,
        )
        self._base, self._sliding, self._gains, self._resistance = (
            namespace(like).asarray(mask, device=like.device) for mask in masks
        )

    def draw(self, index: Array, uniform: Array) -> None:
        """Randomise robots ``index`` (n,) by uniform numbers (N, COLUMNS + motors) in [0, 1)."""
        xp, config, nominal = namespace(uniform), self._config, self._nominal
        uniform = uniform[index]
        payload = _within(config.payload, uniform[:, 0, None])
        mass = _within(config.mass, uniform[:, 3, None])
        friction = _within(config.friction or Interval(0.0, 0.0), uniform[:, 4, None, None])
        shift = config.centre_of_mass * (2.0 * uniform[:, None, 5:8] - 1.0)
        gain = _within(config.motor_gain, uniform[:, 8:, None])
        # The gain scales the torque at every voltage, but not the voltages of the onboard loop:
        # MuJoCo turns the demanded torque into voltage with the resistance; the gains compensate.
        parameters = nominal["actuator_gainprm"] * xp.where(self._gains, gain, 1.0)
        fields = {
            "body_mass": mass * nominal["body_mass"] + self._base * payload,
            "body_inertia": mass[:, :, None] * nominal["body_inertia"],
            "body_ipos": nominal["body_ipos"] + self._base[:, None] * shift,
            "geom_friction": xp.where(self._sliding, friction, nominal["geom_friction"]),
            "actuator_gainprm": parameters / xp.where(self._resistance, gain, 1.0),
            "actuator_forcerange": nominal["actuator_forcerange"] * gain,
        }
        self._write(index, fields)
        self.motor_gain[index] = gain[:, :, 0]


def _within(interval: Interval, uniform: Array) -> Array:
    return interval.lower + (interval.upper - interval.lower) * uniform
