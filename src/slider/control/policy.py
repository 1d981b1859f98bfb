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
        agent: observations, actions and clock of N robots; stays at hand as an attribute.
    """

    def __init__(
        self, network: Callable[[torch.Tensor], torch.Tensor], agent: AgentInterface
    ) -> None:
        self._network = network
        self.agent = agent
        self._started = False
        self._everyone = np.arange(agent.num_robots)
        self._velocity = agent.command[:, :3].copy()

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start anew with clocks at zero (left stance), commanded to ``velocity`` (N, 3)."""
        self.command(velocity)
        self.agent.set_velocity_command(self._everyone, velocity)
        self.agent.reset(self._everyone, state)
        self.agent.refresh_heading(state)
        self._started = False

    def command(self, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from the next observation on, as in training."""
        self._velocity = velocity

    def control(self, state: RobotState) -> np.ndarray:
        """Desired joint positions (N, 12) [rad or m]."""
        if self._started:
            self.agent.advance(state)  # with the command of the period that is over
            self.agent.set_velocity_command(self._everyone, self._velocity)
        self._started = True
        with torch.inference_mode():
            actions = self._network(torch.from_numpy(self.agent.observe(state)))
        return self.agent.act(actions.numpy().astype(np.float64))
