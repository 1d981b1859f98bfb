"""The physics of many robots on a device, behind the methods of ``BatchedPhysics``.

Nothing in :meth:`WarpPhysics.step`, :meth:`WarpPhysics.read` and :meth:`WarpPhysics.reset` waits
for the device: robots are chosen by masks, and all arrays are float32 tensors there.
"""

from typing import Any

import torch

from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.core.arrays import put
from slider.env.disturbance.disturber import Disturber, build_plant
from slider.env.disturbance.draws import Disturbance
from slider.env.disturbance.machines import vary
from slider.env.reading import SPEED_LIMIT, SensorIndex, read
from slider.env.state import RobotState
from slider.env.warp.machines import FIELDS, WarpMachines
from slider.env.warp.simulation import ROWS, Simulation
from slider.robot.mjcf import Actuation, SimulationOptions, nominal_qpos
from slider.robot.transmission import Transmission


class WarpPhysics:
    """Steps ``num_robots`` copies of the robot on flat ground, disturbed as in ``BatchedPhysics``.

    Evaluation needs contacts and loads of every simulation step and runs on MuJoCo itself. An
    index of some robots is a mask (N,), and the rows that belong to it are those of all.

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
        varied = FIELDS if disturbance is not None and vary(disturbance.config) else ()
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
        self._diverged, self._retired = torch.zeros(
            (2, num_robots), dtype=torch.bool, device=self.device
        )
        self._anyone_retired = False
        self._disturber: Any = None  # its arrays are tensors
        if disturbance is not None:
            robots = (
                WarpMachines(self.simulation, self.model, disturbance.config) if varied else None
            )
            self._disturber = Disturber(
                disturbance, robot, self.model, actuation, num_robots, robots, self.qpos
            )
        self._place(~self._retired, self._rest, torch.zeros_like(self.qvel))

    @property
    def device(self) -> torch.device:
        """Where the tensors are."""
        return self.simulation.device

    def _tensor(self, values: Any) -> torch.Tensor:
        return torch.as_tensor(values, dtype=torch.float32, device=self.device).contiguous()

    def _place(self, robots: torch.Tensor, qpos: torch.Tensor, qvel: torch.Tensor) -> None:
        """Put ``robots`` at positions and velocities, with empty sensors."""
        put(self.qpos, robots, qpos)
        put(self.qvel, robots, qvel)
        put(self._sensors, robots, 0.0)

    def reset(self, robots: torch.Tensor, qpos: torch.Tensor, qvel: torch.Tensor) -> None:
        """Place ``robots`` (N,), a mask, at positions (N, 19) and velocities (N, 18)."""
        if self._disturber is not None:
            qpos = self._disturber.begin(robots, qpos)
        self._place(robots, qpos, qvel)
        self._diverged &= ~robots
        self._retired &= ~robots

    def retire(self, robots: torch.Tensor) -> None:
        """Leave ``robots`` (N,), a mask, where they are until they are placed anew."""
        self._retired |= robots
        self._anyone_retired = True

    def step(self, inputs: torch.Tensor) -> None:
        """Simulate one ``period`` [s] with constant inputs (N, 12) [rad or m; N m or N]."""
        held = self._held()
        control = (inputs @ self._to_motors)[:, None].expand(-1, len(self.simulation.control), -1)
        if self._disturber is not None:
            self._disturber.push(self.qvel)
            control = self._disturber.drive(control)
        self.simulation.control.copy_(control.transpose(0, 1))
        self.simulation.step()
        lost = self._find_diverged(inputs)
        if held is not None:
            lost &= ~self._retired
            for now, before in zip((self.qpos, self.qvel, self._sensors), held, strict=True):
                now.copy_(torch.where(self._retired[:, None], before, now))
        self._diverged.copy_(lost)
        self.simulation.forgive(lost)
        self._place(lost, self._rest, torch.zeros_like(self.qvel))

    def _held(self) -> tuple[torch.Tensor, ...] | None:
        """What retired robots keep; none where none ever retired."""
        if not self._anyone_retired:
            return None
        return self.qpos.clone(), self.qvel.clone(), self._sensors.clone()

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
        return state if self._disturber is None else self._disturber.sense(state)

    def restart_disturbances(self) -> None:
        """Let the same disturbances follow as after construction."""
        if self._disturber is not None:
            self._disturber.restart()
