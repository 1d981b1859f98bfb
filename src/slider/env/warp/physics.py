"""The physics of many robots on a device, behind the methods of ``BatchedPhysics``.

All arrays are float32 tensors on the device. Nothing in a step waits for it.
"""

# pyright: reportAttributeAccessIssue=false

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
import torch

from slider.config.env import DisturbanceConfig, PhysicsConfig
from slider.config.robot import RobotConfig
from slider.env.disturbance.disturber import Disturber, build_plant
from slider.env.disturbance.draws import Disturbance
from slider.env.disturbance.models import (
    GAIN_COLUMNS,
    RESISTANCE,
    SLIDING,
    drawn,
    feet,
    vary,
)
from slider.env.reading import SPEED_LIMIT, SensorIndex, read
from slider.env.state import RobotState
from slider.env.warp.simulation import ROWS, Simulation
from slider.robot import names
from slider.robot.mjcf import Actuation, SimulationOptions, nominal_qpos
from slider.robot.transmission import Transmission

VARIED_FIELDS = (
    *("body_mass", "body_inertia", "body_ipos", "geom_friction"),
    *("actuator_gainprm", "actuator_forcerange"),
)


class WarpPhysics:
    """Steps ``num_robots`` copies of the robot on flat ground, disturbed as in ``BatchedPhysics``.

    Evaluation needs contacts and loads of every simulation step and runs on MuJoCo itself.

    Attributes:
        qpos, qvel: (N, 19), (N, 18) positions and velocities, shared with the simulation.
        simulation: MuJoCo Warp's.
        model: of the nominal robot.
    """

    def __init__(
        self,
        robot: RobotConfig,
        config: PhysicsConfig,
        num_robots: int,
        device: str = "cpu",
        disturbance: Disturbance | None = None,
        actuation: Actuation = "position",
        rows: int = ROWS,
    ) -> None:
        options = SimulationOptions(
            config.timestep,
            config.solver_iterations,
            config.line_search_iterations,
            actuation=actuation,
        )
        self.robot, self.num_robots = robot, num_robots
        self.period = config.substeps * config.timestep
        self.model = build_plant(robot, options, None)
        varied = VARIED_FIELDS if disturbance is not None and vary(disturbance.config) else ()
        self.simulation = Simulation(self.model, num_robots, config.substeps, device, varied, rows)
        self.qpos, self.qvel = self.simulation.qpos, self.simulation.qvel
        self._sensors = self.simulation.sensors
        self._index: Any = SensorIndex(self.model)
        for name, columns in vars(self._index).items():  # a list would be copied to the device
            setattr(self._index, name, torch.tensor(columns, device=self.device))
        motors = Transmission.of(robot)
        matrix = motors.inverse if actuation == "torque" else motors.matrix
        self._to_motors = self._tensor(matrix.T)
        self._rest = self._tensor(nominal_qpos(robot))
        self._diverged = torch.zeros(num_robots, dtype=torch.bool, device=self.device)
        self._disturber: Any = None  # its arrays are tensors
        if disturbance is not None:
            robots = None
            if varied:
                robots = WarpModels(self.simulation, self.model, disturbance.config)
            self._disturber = Disturber(
                disturbance, robot, self.model, actuation, num_robots, robots, self.qpos
            )
        self._place_at_rest(torch.ones_like(self._diverged))

    @property
    def device(self) -> torch.device:
        """Where the tensors are."""
        return self.simulation.device

    def _tensor(self, values: Any) -> torch.Tensor:
        return torch.as_tensor(values, dtype=torch.float32, device=self.device).contiguous()

    def _place_at_rest(self, robots: torch.Tensor) -> None:
        """Put ``robots`` (N,), a mask, at rest in the nominal pose, with empty sensors."""
        mask = robots[:, None]
        self.qpos.copy_(self._rest.where(mask, self.qpos))
        self.qvel.masked_fill_(mask, 0.0)
        self._sensors.masked_fill_(mask, 0.0)

    def reset(self, index: torch.Tensor, qpos: torch.Tensor, qvel: torch.Tensor) -> None:
        """Place robots ``index`` (n,) at positions (n, 19) and velocities (n, 18)."""
        if self._disturber is not None:
            qpos = self._disturber.begin(index, qpos)
        self.qpos[index], self.qvel[index] = qpos, qvel
        self._sensors[index] = 0.0
        self._diverged[index] = False

    def step(self, inputs: torch.Tensor) -> None:
        """Simulate one ``period`` [s] with constant inputs (N, 12) [rad or m; N m or N]."""
        control = (inputs @ self._to_motors)[:, None].expand(-1, len(self.simulation.control), -1)
        if self._disturber is not None:
            self._disturber.push(self.qvel)
            control = self._disturber.drive(control)
        self.simulation.control.copy_(control.transpose(0, 1))
        self.simulation.step()
        self._diverged.copy_(self._find_diverged(inputs))
        self.simulation.clear_errors(self._diverged)
        self._place_at_rest(self._diverged)

    def _find_diverged(self, inputs: torch.Tensor) -> torch.Tensor:
        values = (self.qpos, self.qvel, self._sensors, inputs)
        finite = torch.stack([x.isfinite().all(dim=1) for x in values]).all(dim=0)
        return ~finite | (self.qvel.abs() > SPEED_LIMIT).any(dim=1)

    def check(self) -> None:
        """Look for lost contacts since the last call; this waits for the device.

        Raises:
            UserError: the simulation of some robots overflowed.
        """
        self.simulation.check()

    def read(self) -> RobotState:
        """Name the quantities of the current state."""
        return read(self.qpos, self.qvel, self._sensors, self._index, self._diverged)

    def measure(self, state: RobotState) -> RobotState:
        """The state as a controller receives it: with sensor noise."""
        return state if self._disturber is None else self._disturber.measure(state)

    def restart_disturbances(self) -> None:
        """Let the same disturbances follow as after construction."""
        if self._disturber is not None:
            self._disturber.restart()


class WarpModels:
    """Models of the robots of a simulation, drawn again per robot and episode.

    Attributes:
        motor_gain: (N, 10) by which demanded torques are scaled [-].
    """

    def __init__(
        self, simulation: Simulation, nominal: mujoco.MjModel, config: DisturbanceConfig
    ) -> None:
        self._simulation, self._config = simulation, config
        self._fields = {name: simulation.field(name) for name in VARIED_FIELDS}
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

    def draw(self, index: torch.Tensor, uniform: torch.Tensor) -> None:
        """Draw robots ``index`` (n,) again by numbers (N, COLUMNS) in [0, 1)."""
        new, nominal = drawn(self._config, uniform[index]), self._nominal
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
            self._fields[name][index] = value
        self.motor_gain[index] = new.gain
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
