"""The agent's side of a policy from a file."""

from slider.control.policy_file import Policy
from slider.core.config.env import EnvConfig
from slider.core.config.robot import RobotConfig
from slider.core.errors import UserError
from slider.env.interface import AgentInterface


def agent_of(policy: Policy, robot: RobotConfig, env: EnvConfig, count: int) -> AgentInterface:
    """Observations and actions of ``count`` robots that the policy leads.

    Args:
        policy: read from a file.
        robot, env: the machine and what an agent sees and commands there.
        count: number of robots.

    Raises:
        UserError: the policy is for other observations, or its actions have another origin.
    """
    if env.action.about != policy.env.action.about:
        raise UserError(
            f"policy: expected env.action.about={policy.env.action.about}, as in its training, "
            f"found {env.action.about}"
        )
    agent = AgentInterface(robot, env, count, policy.times, policy.reference)
    if list(agent.observer.layout.items()) != list(policy.observations.items()):  # order counts
        raise UserError(
            f"policy: expected the observations {agent.observer.layout}, "
            f"found {policy.observations}"
        )
    return agent
