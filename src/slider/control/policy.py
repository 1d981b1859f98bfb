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
        agent: observations, actions and clock of N robots.
    """

    def __init__(
        self, network: Callable[[torch.Tensor], torch.Tensor], agent: AgentInterface
    ) -> None:
        self._network = network
        self._agent = agent
        self._started = False

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start anew with clocks at zero (left stance), commanded to ``velocity`` (N, 3)."""
        everyone = np.arange(self._agent.num_robots)
        self._agent.set_velocity_command(everyone, velocity)
        self._agent.reset(everyone, state)
        self._agent.refresh_heading(state)
        self._started = False

    def control(self, state: RobotState) -> np.ndarray:
        """Desired joint positions (N, 12) [rad or m]."""
        if self._started:
            self._agent.advance(state)
        self._started = True
        with torch.inference_mode():
            actions = self._network(torch.from_numpy(self._agent.observe(state)))
        return self._agent.act(actions.numpy().astype(np.float64))
