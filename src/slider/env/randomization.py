"""Robots that differ from the nominal one: masses, centre of mass, friction, motors.

Every robot has a MuJoCo model of its own (about 0.15 MB), which ``mujoco.rollout`` takes as a list
at no cost in time.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import copy
from typing import Any, NamedTuple

import mujoco
import numpy as np

from slider.config.env import DisturbanceConfig
from slider.config.types import Interval
from slider.robot import names

_DRIVES = len(names.MOTORS)
# Uniform numbers per robot: payload, one in reserve, delay, mass, friction, centre of mass, motors.
DELAY, COLUMNS = 2, 8 + _DRIVES
# Places of a DC motor's parameters: resistance, position gain and velocity gain.
RESISTANCE, GAIN_COLUMNS = 0, [4, 6]
SLIDING = 0


class Drawn(NamedTuple):
    """What makes N robots differ, as arrays or tensors.

    Attributes:
        payload: (N,) added to the base [kg].
        mass: (N,) of all bodies, relative to the nominal one [-].
        friction: (N,) of the feet [-]; the nominal one if none.
        shift: (N, 3) of the base's centre of mass [m].
        gain: (N, 10) torque of the motors, relative to the nominal one [-].
    """

    payload: Any
    mass: Any
    friction: Any
    shift: Any
    gain: Any


def drawn(config: DisturbanceConfig, uniform: Any) -> Drawn:
    """Robots of numbers (N, COLUMNS) in [0, 1), an array or a tensor."""
    friction = config.friction
    return Drawn(
        payload=_within(config.payload, uniform[:, 0]),
        mass=_within(config.mass, uniform[:, 3]),
        friction=None if friction is None else _within(friction, uniform[:, 4]),
        shift=config.centre_of_mass * (2.0 * uniform[:, 5:8] - 1.0),
        gain=_within(config.motor_gain, uniform[:, 8:]),
    )


def feet(model: mujoco.MjModel) -> np.ndarray:
    """Geoms of the feet."""
    bodies = [model.body(names.foot(side)).id for side in names.SIDES]
    return np.flatnonzero(np.isin(model.geom_bodyid, bodies))


def vary(config: DisturbanceConfig) -> bool:
    """Whether robots differ from the nominal one."""
    fixed = config.mass == config.motor_gain == Interval(1.0, 1.0)
    loaded = config.payload.upper > 0
    return not fixed or loaded or config.centre_of_mass > 0 or config.friction is not None


class RandomizedModels:
    """Models of ``count`` robots, drawn again per robot and episode.

    Attributes:
        models: of each robot.
        masses: (N,) [kg].
        motor_gain: (N, 10) by which demanded torques are scaled [-].
    """

    def __init__(self, nominal: mujoco.MjModel, config: DisturbanceConfig, count: int) -> None:
        self.models = [copy.copy(nominal) for _ in range(count)]
        self.masses = np.full(count, float(nominal.body_mass.sum()))
        self.motor_gain = np.ones((count, _DRIVES))
        self._nominal, self._config = nominal, config
        self._data = mujoco.MjData(nominal)
        self._base = nominal.body(names.BASE).id
        self._feet = feet(nominal)

    def draw(self, index: np.ndarray, uniform: np.ndarray) -> None:
        """Draw robots ``index`` (n,) again by numbers (N, COLUMNS) in [0, 1)."""
        new = drawn(self._config, uniform)
        for i in index:
            model, nominal, mass = self.models[i], self._nominal, float(new.mass[i])
            model.body_mass[:] = mass * nominal.body_mass
            model.body_mass[self._base] += float(new.payload[i])
            model.body_inertia[:] = mass * nominal.body_inertia
            model.body_ipos[self._base] = nominal.body_ipos[self._base] + new.shift[i]
            # Torque scales at every voltage while the on-board loop keeps its volts: MuJoCo turns
            # the demanded torque into volts with the resistance, and the gains make up for that.
            gain, parameters = new.gain[i], nominal.actuator_gainprm
            model.actuator_gainprm[:, RESISTANCE] = parameters[:, RESISTANCE] / gain
            for column in GAIN_COLUMNS:
                model.actuator_gainprm[:, column] = parameters[:, column] * gain
            model.actuator_forcerange[:] = nominal.actuator_forcerange * gain[:, None]
            if new.friction is not None:
                model.geom_friction[self._feet, SLIDING] = new.friction[i]
            mujoco.mj_setConst(model, self._data)
            self.masses[i] = float(model.body_mass.sum())
        self.motor_gain[index] = new.gain[index]


def _within(interval: Interval, uniform: Any) -> Any:
    return interval.lower + (interval.upper - interval.lower) * uniform
