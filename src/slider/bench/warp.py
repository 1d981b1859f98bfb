"""Control steps per second of MuJoCo Warp alone."""

import numpy as np
import torch

from slider.env.task import Task
from slider.env.warp.physics import WarpPhysics


class BareWarp:
    """Repeats recorded control steps on a device.

    Args:
        task: whose robots they are.
        device: such as ``cpu`` or ``cuda:0``.
        recorded: MuJoCo's full states (N, 38) and motor angles (N, 10).
    """

    def __init__(
        self, task: Task, device: str, recorded: list[tuple[np.ndarray, np.ndarray]]
    ) -> None:
        physics = WarpPhysics(task.robot, task.env.physics, task.train.robots, device)
        self._simulation, positions = physics.simulation, physics.model.nq
        self._recorded = [
            tuple(
                torch.as_tensor(values, dtype=torch.float32, device=physics.device)
                for values in (state[:, 1 : 1 + positions], state[:, 1 + positions :], angles)
            )
            for state, angles in recorded
        ]

    def __call__(self) -> int:
        """Simulate them all; the number of control steps of one robot."""
        simulation = self._simulation
        for qpos, qvel, angles in self._recorded:
            simulation.qpos.copy_(qpos)
            simulation.qvel.copy_(qvel)
            simulation.control.copy_(angles)
            simulation.step()
        simulation.check()  # waits for the device
        return len(self._recorded) * len(simulation.qpos)
