"""Control steps of MuJoCo Warp, recorded and repeated without anything else."""

from collections.abc import Callable

import torch

from slider.bench.stopwatch import replaced
from slider.env.task import Task
from slider.env.warp.physics import WarpPhysics
from slider.env.warp.simulation import Simulation
from slider.training.distributed import device_of

Step = tuple[torch.Tensor, torch.Tensor, torch.Tensor]
"""Positions (N, 19), velocities (N, 18) and inputs of the motors (S, N, 10) of a control step."""


def record(simulation: Simulation, work: Callable[[], object]) -> list[Step]:
    """The control steps that ``work`` simulates."""
    steps, real = [], simulation.step

    def step() -> None:
        steps.append(
            tuple(x.clone() for x in (simulation.qpos, simulation.qvel, simulation.control))
        )
        real()

    with replaced(simulation, "step", step):
        work()
    return steps


class BareWarp:
    """Repeats recorded control steps with the nominal robot.

    Args:
        task: whose robots they are, on its device.
        recorded: what to repeat.
    """

    def __init__(self, task: Task, recorded: list[Step]) -> None:
        train = task.train
        physics = WarpPhysics(task.robot, task.env.physics, train.robots, device_of(train.device))
        self.simulation, self._recorded = physics.simulation, recorded

    def __call__(self) -> int:
        """Simulate them all; the number of control steps of one robot."""
        simulation = self.simulation
        for qpos, qvel, control in self._recorded:
            simulation.qpos.copy_(qpos)
            simulation.qvel.copy_(qvel)
            simulation.control.copy_(control)
            simulation.step()
        simulation.check()  # waits for the device
        return len(self._recorded) * len(simulation.qpos)
