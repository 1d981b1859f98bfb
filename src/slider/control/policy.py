"""The learned policy as a controller."""

from collections.abc import Callable

import numpy as np
import torch

from slider.env.interface import AgentInterface
from slider.env.state import RobotState


class PolicyController:
    """Runs a network on N robots through the same interface as in training.

    Args:
        network: observations (N, size) → actions (N, 12), deterministic.
        agent: observations, actions and clock of N robots; stays at hand as an attribute. With a
            controller under the actions the plant has several ticks per observation.
    """

    def __init__(
        self, network: Callable[[torch.Tensor], torch.Tensor], agent: AgentInterface
    ) -> None:
        self._network = network
        self.agent = agent
        self._tick = 0
        self._acted = np.zeros(0)
        self._everyone = np.arange(agent.num_robots)
        self._velocity = agent.command[:, :3].copy()

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start anew with clocks at zero (left stance), commanded to ``velocity`` (N, 3)."""
        self.command(velocity)
        self.agent.set_velocity_command(self._everyone, velocity)
        self.agent.reset(self._everyone, state)
        self.agent.refresh_heading(state)
        self._tick = 0

    def command(self, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from the next observation on, as in training."""
        self._velocity = velocity

    def control(self, state: RobotState) -> np.ndarray:
        """Desired joint positions (N, 12) [rad or m], or torques [N m or N] of a torque plant."""
        if self._tick % self.agent.ticks == 0:
            self._acted = self._act(state)
        self._tick += 1
        return self.agent.inputs(self._acted, state)

    def _act(self, state: RobotState) -> np.ndarray:
        if self._tick:
            self.agent.advance(state)  # with the command of the period that is over
            self.agent.set_velocity_command(self._everyone, self._velocity)
        with torch.inference_mode():
            actions = self._network(torch.from_numpy(self.agent.observe(state)))
        return self.agent.act(actions.numpy().astype(np.float64))
