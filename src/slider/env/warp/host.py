"""MuJoCo Warp below the environment, whose terms are computed with NumPy on the processor.

Inputs go to the device and the state comes back in every control step.
"""

from dataclasses import fields, replace

import numpy as np
import torch

from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.core.errors import UserError
from slider.env.disturbance.disturber import Disturber
from slider.env.disturbance.draws import Disturbance
from slider.env.disturbance.machines import vary
from slider.env.state import RobotState
from slider.env.warp.physics import WarpPhysics


class HostPhysics:
    """What the environment needs of ``BatchedPhysics``: arrays in and out, simulated on a device.

    Raises:
        UserError: the disturbance varies robots or ground, or the simulation overflowed.
    """

    def __init__(
        self,
        robot: RobotConfig,
        config: PhysicsConfig,
        num_robots: int,
        device: str,
        disturbance: Disturbance,
    ) -> None:
        if vary(disturbance.config) or disturbance.config.ground.amplitude > 0:
            expected = "simulator: expected mujoco where robots or ground vary"
            raise UserError(f"{expected}, found mujoco_warp")
        self._warp = WarpPhysics(robot, config, num_robots, device)
        self.model, self.period, self.num_robots = self._warp.model, self._warp.period, num_robots
        self._disturber = Disturber(disturbance, robot, self.model, "position", num_robots)
        self._warp.disturber = _OfArrays(self._disturber)

    def step(self, inputs: np.ndarray) -> None:
        """Simulate one ``period`` [s] with constant inputs (N, 12) [rad or m]."""
        self._warp.step(_tensor(inputs, self._warp.qpos))
        self._warp.check()

    def reset(self, index: np.ndarray, qpos: np.ndarray, qvel: np.ndarray) -> None:
        """Place robots ``index`` at positions (n, 19) and velocities (n, 18)."""
        qpos = self._disturber.begin(index, qpos)
        robots = torch.zeros(self.num_robots, dtype=torch.bool)
        robots[torch.from_numpy(index)] = True
        rows = [np.zeros((self.num_robots, values.shape[1])) for values in (qpos, qvel)]
        for whole, values in zip(rows, (qpos, qvel), strict=True):
            whole[index] = values
        like = self._warp.qpos
        self._warp.reset(robots.to(like.device), *(_tensor(whole, like) for whole in rows))

    def read(self) -> RobotState:
        """Name the quantities of the current state."""
        state = self._warp.read()
        found = {field.name: getattr(state, field.name) for field in fields(state)}
        arrays = {k: _array(v) for k, v in found.items() if isinstance(v, torch.Tensor)}
        return replace(state, **arrays)

    def measure(self, state: RobotState) -> RobotState:
        """The state as a controller receives it: with sensor noise."""
        return self._disturber.sense(state)


class _OfArrays:
    """A disturber of arrays for a simulation of tensors."""

    def __init__(self, disturber: Disturber) -> None:
        self._disturber = disturber

    def begin(self, robots: torch.Tensor, qpos: torch.Tensor) -> torch.Tensor:
        return qpos  # HostPhysics has drawn the robots

    def push(self, qvel: torch.Tensor) -> None:
        moved = _array(qvel)
        self._disturber.push(moved)
        qvel.copy_(_tensor(moved, qvel))

    def drive(self, control: torch.Tensor) -> torch.Tensor:
        return _tensor(self._disturber.drive(_array(control)), control)

    def sense(self, state: RobotState) -> RobotState:
        return self._disturber.sense(state)

    def restart(self) -> None:
        self._disturber.restart()


def _tensor(values: np.ndarray, like: torch.Tensor) -> torch.Tensor:
    return torch.from_numpy(np.ascontiguousarray(values)).to(like)


def _array(values: torch.Tensor) -> np.ndarray:
    found = values.cpu().numpy()
    return found.astype(np.float64) if found.dtype == np.float32 else found.copy()
