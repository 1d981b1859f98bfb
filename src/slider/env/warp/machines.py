"""Robots that differ from the nominal one, as fields of one model on the device."""

# pyright: reportAttributeAccessIssue=false

from collections.abc import Sequence

import mujoco
import numpy as np
import torch

from slider.config.disturbance import DisturbanceConfig
from slider.core.arrays import put
from slider.env.disturbance.machines import GAIN_COLUMNS, RESISTANCE, SLIDING, drawn, feet
from slider.env.warp.simulation import Simulation
from slider.robot import names

FIELDS = (
    *("body_mass", "body_inertia", "body_ipos", "geom_friction"),
    *("actuator_gainprm", "actuator_forcerange"),
)


class WarpMachines:
    """Models of the robots of a simulation, drawn anew per robot and episode.

    Attributes:
        motor_gain: (N, 10) by which demanded torques are scaled [-].
    """

    def __init__(
        self, simulation: Simulation, nominal: mujoco.MjModel, config: DisturbanceConfig
    ) -> None:
        self._simulation, self._config = simulation, config
        self._fields = {name: simulation.field(name) for name in FIELDS}
        count, device = len(simulation.qpos), simulation.device
        self._nominal = {
            name: torch.as_tensor(getattr(nominal, name), dtype=field.dtype).to(device)
            for name, field in self._fields.items()
        }
        self.motor_gain = torch.ones((count, len(names.MOTORS)), device=device)
        parameters = self._fields["actuator_gainprm"].shape[2]
        self._base = _ones_at([nominal.body(names.BASE).id], nominal.nbody).to(device)
        self._loop = _ones_at(GAIN_COLUMNS, parameters).to(device)
        self._resistance = _ones_at([RESISTANCE], parameters).to(device)
        sliding = _ones_at(feet(nominal), nominal.ngeom)[:, None] * _ones_at([SLIDING], 3)
        self._sliding = (sliding > 0).to(device)

    def draw(self, robots: torch.Tensor, uniform: torch.Tensor) -> None:
        """Make ``robots`` (N,), a mask, anew from numbers (N, COLUMNS) in [0, 1)."""
        new, nominal = drawn(self._config, uniform), self._nominal
        mass, gain = new.mass[:, None], new.gain[:, :, None]
        scale = 1.0 + self._loop * (gain - 1.0) + self._resistance * (1.0 / gain - 1.0)
        friction = nominal["geom_friction"]
        if new.friction is not None:
            friction = torch.where(self._sliding, new.friction[:, None, None], friction)
        values = {
            "body_mass": mass * nominal["body_mass"],
            "body_inertia": mass[:, :, None] * nominal["body_inertia"],
            "body_ipos": nominal["body_ipos"] + self._base[:, None] * new.shift[:, None],
            "geom_friction": friction,
            "actuator_gainprm": nominal["actuator_gainprm"] * scale,
            "actuator_forcerange": nominal["actuator_forcerange"] * gain,
        }
        for name, value in values.items():
            put(self._fields[name], robots, value)
        put(self.motor_gain, robots, new.gain)
        self._simulation.derive()

    @property
    def masses(self) -> torch.Tensor:
        """Masses of the robots (N,) [kg]."""
        return self._fields["body_mass"].sum(dim=1)


def _ones_at(index: Sequence[int] | np.ndarray, size: int) -> torch.Tensor:
    """Ones at ``index`` among zeros (size,)."""
    values = torch.zeros(size)
    values[torch.as_tensor(index)] = 1.0
    return values
