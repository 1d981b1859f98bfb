"""The small periodic evaluation that picks the checkpoint to keep."""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace

import numpy as np
import torch

from slider.control.policy import PolicyController
from slider.env.disturbance import Disturbance
from slider.env.interface import AgentInterface
from slider.env.metrics import gait_quality, tracking
from slider.env.physics import BatchedPhysics
from slider.env.rollout import roll_out
from slider.env.starts import USUAL_NOISE, at_rest
from slider.env.vec_env import Task


@dataclass(frozen=True)
class Score:
    """Result of one check; lower ``value`` is better.

    Attributes:
        value: mean cost of a robot: fall_weight if it fell, else b·e / (b + e), where b is
            fall_weight / 2 and e the survivors' mean of (mean squared velocity error) /
            (0.01 + 0.01 v²), v the command. Even the worst tracking costs less than half of a fall.
        success: share of robots that survived.
        tracked: share that survived and kept to 0.1 m/s, or a tenth, of the command.
        speed_error: mean over survivors of |mean forward velocity − command| [m/s]; NaN if none.
        flight: survivors' mean share of time with no foot on the ground; NaN if none.
    """

    value: float
    success: float
    tracked: float
    speed_error: float
    flight: float

    def numbers(self) -> dict[str, float]:
        """The values that are not NaN; some need survivors."""
        return {name: value for name, value in asdict(self).items() if not math.isnan(value)}


class Selector:
    """Evaluates policies on a few robots per command, always from the same starts."""

    def __init__(self, task: Task, threads: int) -> None:
        robot, env, config = task.robot, task.env, task.train.selection
        self._env, self._config = env, config
        count = len(config.speeds) * config.robots
        disturbance = task.train.disturbance
        terrain = replace(disturbance.terrain, curriculum=False)  # all of its levels
        disturbed = Disturbance(replace(disturbance, terrain=terrain), (config.seed,))
        self._physics = BatchedPhysics(
            robot, env.physics, count, threads, disturbance=disturbed, onboard=env.estimation
        )
        self._agent = AgentInterface(robot, env, count, task.times, task.reference)
        self._start = at_rest(robot, USUAL_NOISE, np.random.default_rng(config.seed), count)
        self._command = np.zeros((count, 3))
        self._command[:, 0] = np.repeat(config.speeds, config.robots)
        if self._physics.terrain is not None:
            self._command[:, 0] *= self._physics.terrain.speeds(task.train.velocities.uneven)

    def score(self, network: Callable[[torch.Tensor], torch.Tensor]) -> Score:
        """Score of a deterministic policy."""
        config = self._config
        controller = PolicyController(network, self._agent)
        recording = roll_out(
            controller, self._physics, self._env, self._start, self._command, config.duration
        )
        tracked = tracking(recording, config.warm_up, 0.1, 0.1)
        command = self._command[:, 0]
        success = float(tracked["survived"].mean())
        error = _mean(tracked["squared_error_steady"] / (0.01 + 0.01 * command**2))
        bound = config.fall_weight / 2
        value = config.fall_weight * (1.0 - success)
        if success > 0:
            value += bound * error / (bound + error) * success
        return Score(
            value=value,
            success=success,
            tracked=float(tracked["tracked"].mean()),
            speed_error=_mean(np.abs(tracked["mean_velocity"] - command)),
            flight=_mean(gait_quality(recording, config.warm_up)["flight"]),
        )


def _mean(values: np.ndarray) -> float:
    """Mean over survivors; NaN where there is none."""
    valid = values[~np.isnan(values)]
    return float(valid.mean()) if len(valid) else math.nan
