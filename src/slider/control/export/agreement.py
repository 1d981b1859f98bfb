"""Do the exported networks act like the policy? Asked on observations of a roll-out."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnxruntime
import torch

from slider.control.export.layout import INPUT
from slider.control.policy import PolicyController
from slider.control.policy_file import Policy
from slider.core.errors import UserError
from slider.env.interface import AgentInterface
from slider.env.physics import BatchedPhysics
from slider.env.rollout import roll_out
from slider.env.starts import USUAL_NOISE, at_rest

TOLERANCE = 1e-5  # of an action
SPEEDS = (0.0, 0.4, 0.8, 1.2, 2.2, 3.0)  # commands of the roll-out [m/s]
_ROBOTS = 4  # per command


@dataclass(frozen=True)
class Agreement:
    """Largest differences of an action from the policy's over ``observations`` observations."""

    observations: int
    onnx: float
    torch_export: float

    def check(self) -> None:
        """Refuse an export that acts differently.

        Raises:
            UserError: a difference is larger than ``TOLERANCE``.
        """
        for name, found in (("ONNX", self.onnx), ("torch.export", self.torch_export)):
            if not found <= TOLERANCE:  # NaN is refused too
                raise UserError(
                    f"policy export: expected the actions of the {name} file within "
                    f"{TOLERANCE:g} of the policy's, found a difference of {found:.3g}"
                )


def record_observations(policy: Policy, duration: float, threads: int = 1) -> np.ndarray:
    """Observations (steps · N, size) of robots that walk under the policy for ``duration`` [s]."""
    count = len(SPEEDS) * _ROBOTS
    seen: list[torch.Tensor] = []

    def network(observations: torch.Tensor) -> torch.Tensor:
        seen.append(observations)
        return policy.network(observations)

    agent = AgentInterface(policy.robot, policy.env, count, policy.times, policy.reference)
    physics = BatchedPhysics(policy.robot, policy.env.physics, count, threads)
    start = at_rest(policy.robot, USUAL_NOISE, np.random.default_rng(0), count)
    command = np.zeros((count, 3))
    command[:, 0] = np.repeat(SPEEDS, _ROBOTS)
    roll_out(PolicyController(network, agent), physics, policy.env, start, command, duration)
    return torch.cat(seen).numpy()


def compare(policy: Policy, onnx: Path, exported: Path, observations: np.ndarray) -> Agreement:
    """Run both files, read back from disk, on observations (N, size)."""
    with torch.inference_mode():
        expected = policy.network(torch.from_numpy(observations)).numpy()
        reloaded = torch.export.load(exported).module()(torch.from_numpy(observations)).numpy()
    return Agreement(
        observations=len(observations),
        onnx=_difference(run_onnx(onnx, observations), expected),
        torch_export=_difference(reloaded, expected),
    )


def run_onnx(path: Path, observations: np.ndarray) -> np.ndarray:
    """Actions (N, 12) of observations (N, size) by onnxruntime, with one thread."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])
    return np.asarray(session.run(None, {INPUT: observations})[0])


def _difference(found: np.ndarray, expected: np.ndarray) -> float:
    return float(np.abs(found - expected).max())
