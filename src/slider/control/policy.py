"""The learned policy as a controller, and the agent's side of a policy from a file."""

from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from slider.config.convert import to_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.control.policy_file import Policy
from slider.core.errors import UserError
from slider.core.files import flatten
from slider.env.interface import FLOAT64, AgentInterface
from slider.env.state import RobotState

_ALL = slice(None)  # robots


class PolicyController:
    """Runs a network on N robots through the same interface as in training.

    Args:
        network: observations (N, size) → actions (N, 12), deterministic.
        agent: observations, actions and clock of N robots; also an attribute.
    """

    def __init__(
        self, network: Callable[[torch.Tensor], torch.Tensor], agent: AgentInterface
    ) -> None:
        self._network = network
        self.agent = agent
        self._started = False
        self._velocity = np.zeros((agent.num_robots, 3))

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start with clocks at zero (left stance), commanded to ``velocity`` (N, 3)."""
        self.set_velocity(velocity)
        state = state.tensors(FLOAT64)
        self.agent.set_velocity_command(_ALL, torch.tensor(velocity))
        self.agent.reset(_ALL, state)
        self.agent.refresh_heading(state)
        self._started = False

    def set_velocity(self, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from the next observation on, as in training."""
        self._velocity = velocity

    def control(self, state: RobotState) -> np.ndarray:
        """Desired joint positions (N, 12) [rad or m], once per control period."""
        state = state.tensors(FLOAT64)
        if self._started:
            self.agent.advance(state)  # with the velocity of the period that is over
            self.agent.set_velocity_command(_ALL, torch.tensor(self._velocity))
        with torch.inference_mode():
            actions = self._network(self.agent.observe(state))
        self._started = True
        return self.agent.act(actions).numpy()


def agent_of(policy: Policy, robot: RobotConfig, env: EnvConfig, count: int) -> AgentInterface:
    """Observations and actions of ``count`` robots under a policy.

    Args:
        policy: read from a file.
        robot, env: machine, observations and actions.
        count: number of robots.

    Raises:
        UserError: the policy is for other observations, actions, clock or control rate.
    """
    trained, given = _interface(policy.env), _interface(env)
    for key in dict.fromkeys([*trained, *given]):
        expected, value = (interface.get(key, "nothing") for interface in (trained, given))
        if value != expected:
            raise UserError(
                f"policy: expected env.{key}={expected}, as in its training, found {value}"
            )
    agent = AgentInterface(robot, env, count, policy.times, policy.reference)
    if list(agent.observer.layout.items()) != list(policy.observations.items()):  # order counts
        raise UserError(
            f"policy: expected the observations {agent.observer.layout}, "
            f"found {policy.observations}"
        )
    return agent


def _interface(env: EnvConfig) -> dict[str, Any]:
    """Settings of observations and actions, by dotted key."""
    parts = ("control_period", "reference", "observation", "action", "phase")
    return flatten({name: value for name, value in to_dict(env).items() if name in parts})
