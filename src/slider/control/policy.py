"""A trained policy: its network, the file with everything to run it, and the controller."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import chdir
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn

from slider.config.convert import from_dict, to_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.core.errors import UserError, require
from slider.core.files import flatten
from slider.env.interface import FLOAT64, AgentInterface
from slider.env.state import RobotState
from slider.library.lookup import GaitTable, StepTimes
from slider.robot.names import NUM_JOINTS, joint_names

FORMAT = "slider-policy"
VERSION = 10
_ALL = slice(None)  # robots
MEAN, STD, VARIANCE = (f"obs_normalizer._{name}" for name in ("mean", "std", "var"))
"""Private names of rsl-rl in the state of an actor."""
UNVARIED = 1e-3  # an observation with a smaller standard deviation did not vary in training
ACTIVATIONS: dict[str, type[nn.Module]] = {"elu": nn.ELU, "relu": nn.ReLU, "tanh": nn.Tanh}


class PolicyNetwork(nn.Module):
    """Deterministic policy: observations (N, num_observations) → actions (N, num_actions)."""

    mean: torch.Tensor
    std: torch.Tensor

    def __init__(
        self, num_observations: int, num_actions: int, hidden: Sequence[int], activation: str
    ) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(num_observations))
        self.register_buffer("std", torch.ones(num_observations))
        sizes = [num_observations, *hidden, num_actions]
        layers: list[nn.Module] = []
        for inputs, outputs in pairwise(sizes):
            layers += [nn.Linear(inputs, outputs), ACTIVATIONS[activation]()]
        self.mlp = nn.Sequential(*layers[:-1])

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Actions of observations, normalised with the statistics of training."""
        return self.mlp((observations - self.mean) / self.std)


def from_actor(
    state: Mapping[str, torch.Tensor], hidden: Sequence[int], activation: str, epsilon: float
) -> PolicyNetwork:
    """Copy an rsl-rl actor's parameters.

    ``state`` is the ``state_dict`` of an ``MLPModel`` with observation normalisation, which adds
    ``epsilon`` to the standard deviation.

    An observation that did not vary in training is not scaled: otherwise a velocity that is new to
    the policy would reach its first layer multiplied by a hundred.
    """
    weights = {k.removeprefix("mlp."): v for k, v in state.items() if k.startswith("mlp.")}
    num_observations = weights["0.weight"].shape[1]
    num_actions = weights[f"{2 * len(hidden)}.bias"].shape[0]  # an activation after each layer
    with torch.random.fork_rng(devices=[]):  # initial weights, overwritten below
        network = PolicyNetwork(num_observations, num_actions, hidden, activation)
    network.mlp.load_state_dict({k: v.clone() for k, v in weights.items()})
    network.mean.copy_(state[MEAN].squeeze(0))
    std = state[STD].squeeze(0)
    network.std.copy_(torch.where(std < UNVARIED, 1.0, std) + epsilon)
    return network.eval()


@dataclass(frozen=True)
class Policy:
    """A trained policy.

    Attributes:
        network: with its normaliser.
        observations: name → width of the observation terms, in order.
        times: step times of the gait library for the clock, or None without a clock.
        robot: of the training; gains, limits and drives.
        env: of the training; control period, scales, clips, phase clock.
        training: seed, iteration and the score that selected the weights.
        reference: joint positions of the gaits, where actions are about the gait.
    """

    network: PolicyNetwork
    hidden: tuple[int, ...]
    activation: str
    observations: dict[str, int]
    times: StepTimes | None
    robot: RobotConfig
    env: EnvConfig
    training: Mapping[str, float]
    reference: GaitTable | None = None


def save_policy(policy: Policy, path: Path) -> None:
    """Write a policy file; loadable with ``torch.load(path, weights_only=True)``."""
    reference = None
    if policy.reference is not None:
        positions = torch.from_numpy(policy.reference.values)
        reference = {**_tensors(policy.reference.times), "positions": positions}
    content = {
        "format": FORMAT,
        "version": VERSION,
        "joints": list(joint_names(policy.robot.geometry)),
        "hidden": list(policy.hidden),
        "activation": policy.activation,
        "observations": policy.observations,
        "state": policy.network.state_dict(),
        "times": None if policy.times is None else _tensors(policy.times),
        "robot": to_dict(policy.robot),
        "env": to_dict(policy.env),
        "training": dict(policy.training),
        "reference": reference,
    }
    save(content, path)


def save(content: Any, path: Path) -> None:
    """Write a file with torch, from its folder: a path that is not ASCII would change its bytes."""
    with chdir(path.parent):
        torch.save(content, path.name)


def load_policy(path: Path) -> Policy:
    """Read a policy file.

    Raises:
        UserError: not a policy file of this project, or of another version or robot.
    """
    try:
        content = torch.load(path, weights_only=True)
    except FileNotFoundError:
        raise UserError(f"expected a policy file at {path}, found none") from None
    except Exception:  # torch raises pickle, zip and runtime errors for foreign files
        raise UserError(f"{path}: expected a policy file of this project") from None
    format_name = content.get("format") if isinstance(content, dict) else type(content).__name__
    require(format_name == FORMAT, str(path), f"format {FORMAT}", format_name)
    require(content["version"] == VERSION, str(path), f"version {VERSION}", content["version"])
    hidden, reference = tuple(content["hidden"]), content["reference"]
    sizes = content["observations"]
    network = PolicyNetwork(sum(sizes.values()), NUM_JOINTS, hidden, content["activation"])
    network.load_state_dict(content["state"])
    if reference is not None:
        positions = reference.pop("positions").numpy()
        reference = GaitTable(_times(reference), positions)
    return Policy(
        network=network.eval(),
        hidden=hidden,
        activation=content["activation"],
        observations=sizes,
        times=None if content["times"] is None else _times(content["times"]),
        robot=from_dict(RobotConfig, content["robot"]),
        env=from_dict(EnvConfig, content["env"]),
        training=content["training"],
        reference=reference,
    )


def _tensors(times: StepTimes) -> dict[str, torch.Tensor]:
    return {name: torch.from_numpy(np.array(value)) for name, value in asdict(times).items()}


def _times(tensors: dict[str, torch.Tensor]) -> StepTimes:
    return StepTimes(**{name: value.numpy() for name, value in tensors.items()})


class PolicyController:
    """Runs a network on N robots through the same interface as in training.

    The network is deterministic: observations (N, size) → actions (N, 12).
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
        """Track ``velocity`` (N, 3) from the next observation on, as in training."""
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

    Raises:
        UserError: the policy is for other observations, actions, clock or control rate.
    """
    parts = ("control_period", "reference", "observation", "action", "phase")
    trained, given = (
        flatten({name: value for name, value in to_dict(each).items() if name in parts})
        for each in (policy.env, env)
    )
    for key in dict.fromkeys([*trained, *given]):
        expected, value = (interface.get(key, "nothing") for interface in (trained, given))
        require(value == expected, "policy", f"env.{key}={expected}, as in its training", value)
    agent = AgentInterface(robot, env, count, policy.times, policy.reference)
    layout, own = agent.observer.layout, policy.observations
    same = list(layout.items()) == list(own.items())  # order counts
    require(same, "policy", f"the observations {layout}", own)
    return agent
