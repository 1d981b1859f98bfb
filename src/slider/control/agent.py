"""The agent's side of a policy from a file."""

from typing import Any

from slider.config.convert import to_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.control.policy_file import Policy
from slider.core.dotted import flatten
from slider.core.errors import UserError
from slider.env.interface import AgentInterface
from slider.env.underlying import Underlying


def agent_of(
    policy: Policy,
    robot: RobotConfig,
    env: EnvConfig,
    count: int,
    underlying: Underlying | None = None,
) -> AgentInterface:
    """Observations and actions of ``count`` robots under a policy.

    Args:
        policy: read from a file.
        robot, env: machine, observations and actions.
        count: number of robots.
        underlying: the controller under the actions, if the policy has one.

    Raises:
        UserError: the policy is for other observations, actions, clock or control rate.
    """
    trained, found = _interface(policy.env), _interface(env)
    for key in dict.fromkeys([*trained, *found]):
        expected, value = (interface.get(key, "nothing") for interface in (trained, found))
        if value != expected:
            raise UserError(
                f"policy: expected env.{key}={expected}, as in its training, found {value}"
            )
    agent = AgentInterface(robot, env, count, policy.times, policy.reference, underlying)
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
