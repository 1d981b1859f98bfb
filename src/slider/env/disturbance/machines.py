"""Robots that differ from the nominal one: masses, centre of mass, friction, motors.

Every robot has a MuJoCo model of its own (about 0.15 MB), which ``mujoco.rollout`` takes as a list
at no cost in time.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import copy

import mujoco
import numpy as np

from slider.config.disturbance import DisturbanceConfig
from slider.config.types import Interval
from slider.robot import names

_DRIVES = len(names.MOTORS)
COLUMNS = 5 + _DRIVES  # uniform numbers per robot: mass, friction, centre of mass, motors
# Places of a DC motor's parameters: resistance, position gain and velocity gain.
_RESISTANCE, _KP, _KD = 0, 4, 6
_SLIDING = 0


def vary(config: DisturbanceConfig) -> bool:
    """Whether robots differ from the nominal one."""
    fixed = config.mass == config.motor_gain == Interval(1.0, 1.0)
    return not fixed or config.centre_of_mass > 0 or config.friction is not None


class Machines:
    """Models of ``count`` robots, drawn anew per robot and episode."""

    def __init__(self, nominal: mujoco.MjModel, config: DisturbanceConfig, count: int) -> None:
        self.models = [copy.copy(nominal) for _ in range(count)]
        self.motor_gain = np.ones((count, _DRIVES))
        self._nominal, self._config = nominal, config
        self._data = mujoco.MjData(nominal)
        self._base = nominal.body(names.BASE).id
        feet = [nominal.body(names.foot(side)).id for side in names.SIDES]
        self._feet = np.flatnonzero(np.isin(nominal.geom_bodyid, feet))

    def draw(self, index: np.ndarray, uniform: np.ndarray) -> None:
        """Make robots ``index`` anew from numbers (N, COLUMNS) in [0, 1)."""
        config = self._config
        mass, gain = _within(config.mass, uniform[:, 0]), _within(config.motor_gain, uniform[:, 5:])
        shift = config.centre_of_mass * (2.0 * uniform[:, 2:5] - 1.0)
        for i in index:
            model = self.models[i]
            self._set_inertia(model, float(mass[i]), shift[i])
            self._set_motors(model, gain[i])
            if config.friction is not None:
                friction = _within(config.friction, uniform[i, 1])
                model.geom_friction[self._feet, _SLIDING] = friction
            mujoco.mj_setConst(model, self._data)
        self.motor_gain[index] = gain[index]

    def masses(self, index: np.ndarray) -> np.ndarray:
        """Masses of robots ``index`` (n,) [kg]."""
        return np.array([float(self.models[i].body_mass.sum()) for i in index])

    def _set_inertia(self, model: mujoco.MjModel, mass: float, shift: np.ndarray) -> None:
        model.body_mass[:] = mass * self._nominal.body_mass
        model.body_inertia[:] = mass * self._nominal.body_inertia
        model.body_ipos[self._base] = self._nominal.body_ipos[self._base] + shift

    def _set_motors(self, model: mujoco.MjModel, gain: np.ndarray) -> None:
        """Scale the torque at every voltage; the on-board loop keeps its volts.

        MuJoCo turns the demanded torque into volts with the resistance: the scaled gains make up
        for that. A demanded torque is scaled by the caller instead.
        """
        nominal = self._nominal
        model.actuator_gainprm[:, _RESISTANCE] = nominal.actuator_gainprm[:, _RESISTANCE] / gain
        for column in (_KP, _KD):
            model.actuator_gainprm[:, column] = nominal.actuator_gainprm[:, column] * gain
        model.actuator_forcerange[:] = nominal.actuator_forcerange * gain[:, None]


def _within(interval: Interval, uniform: np.ndarray) -> np.ndarray:
    return interval.lower + (interval.upper - interval.lower) * uniform
