"""The policy file: network, normaliser, layout, clock and everything else needed to run it."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from slider.config.convert import from_dict, to_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.control.network import PolicyNetwork
from slider.core.errors import UserError
from slider.library.lookup import JointTable, StepTimes
from slider.robot.names import JOINTS

FORMAT = "slider-policy"
VERSION = 7


@dataclass(frozen=True)
class Policy:
    """A trained policy.

    Attributes:
        network: with its normaliser.
        observations: name → width of the observation terms, in order.
        times: step times of the gait library for the clock, or None without a clock.
        robot: what it was trained on; gains, limits and drives.
        env: where it was trained; control period, scales, clips, phase clock.
        facts: where the weights come from: seed, iteration and the score that they were kept for.
        reference: joint positions of the gaits, where actions are about the gait.
        underlying: plain content of the controller under the actions, where there is one
            (``UnderlyingHzd.from_plain``): the policy is nothing without it.
    """

    network: PolicyNetwork
    hidden: tuple[int, ...]
    activation: str
    observations: dict[str, int]
    times: StepTimes | None
    robot: RobotConfig
    env: EnvConfig
    facts: Mapping[str, float]
    reference: JointTable | None = None
    underlying: Mapping[str, Any] | None = None


def save_policy(policy: Policy, path: Path) -> None:
    """Write a policy file; loadable with ``torch.load(path, weights_only=True)``."""
    content = {
        "format": FORMAT,
        "version": VERSION,
        "joints": list(JOINTS),
        "hidden": list(policy.hidden),
        "activation": policy.activation,
        "observations": policy.observations,
        "state": policy.network.state_dict(),
        "times": None if policy.times is None else _tensors(policy.times),
        "robot": to_dict(policy.robot),
        "env": to_dict(policy.env),
        "facts": dict(policy.facts),
        "reference": None if policy.reference is None else _reference_tensors(policy.reference),
    }
    if policy.underlying is not None:
        content["underlying"] = dict(policy.underlying)
    torch.save(content, path)


def load_policy(path: Path) -> Policy:
    """Read a policy file.

    Raises:
        UserError: not a policy file of this project, or of another version or robot.
    """
    content = _read(path)
    hidden = tuple(content["hidden"])
    sizes = content["observations"]
    network = PolicyNetwork(sum(sizes.values()), len(JOINTS), hidden, content["activation"])
    network.load_state_dict(content["state"])
    return Policy(
        network=network.eval(),
        hidden=hidden,
        activation=content["activation"],
        observations=sizes,
        times=None if content["times"] is None else _times(content["times"]),
        robot=from_dict(RobotConfig, content["robot"]),
        env=from_dict(EnvConfig, content["env"]),
        facts=content["facts"],
        reference=_reference(content["reference"]),
        underlying=content.get("underlying"),
    )


def _read(path: Path) -> dict[str, Any]:
    try:
        content = torch.load(path, weights_only=True)
    except FileNotFoundError:
        raise UserError(f"expected a policy file at {path}, found none") from None
    except Exception:  # torch raises pickle, zip and runtime errors for foreign files
        raise UserError(f"{path}: expected a policy file of this project") from None
    found = content.get("format") if isinstance(content, dict) else type(content).__name__
    if found != FORMAT:
        raise UserError(f"{path}: expected format {FORMAT}, found {found}")
    if content["version"] != VERSION:
        raise UserError(f"{path}: expected version {VERSION}, found {content['version']}")
    if tuple(content["joints"]) != JOINTS:
        raise UserError(f"{path}: expected the joints {', '.join(JOINTS)}")
    return content


def _tensors(times: StepTimes) -> dict[str, torch.Tensor]:
    return {name: torch.from_numpy(np.array(value)) for name, value in asdict(times).items()}


def _times(tensors: dict[str, torch.Tensor]) -> StepTimes:
    return StepTimes(**{name: value.numpy() for name, value in tensors.items()})


def _reference_tensors(reference: JointTable) -> dict[str, torch.Tensor]:
    return {**_tensors(reference.times), "positions": torch.from_numpy(reference.positions)}


def _reference(tensors: dict[str, torch.Tensor] | None) -> JointTable | None:
    """The gaits under the actions; files from before there was such a choice have none."""
    if tensors is None:
        return None
    times = {name: value for name, value in tensors.items() if name != "positions"}
    return JointTable(_times(times), tensors["positions"].numpy())
