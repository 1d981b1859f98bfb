"""PPO with annealed action noise; the exported actor is a moving average over updates.

Noise shifts the mean speed of a policy, so that a policy trained with noise tracks another speed
without it. Single updates move the mean speed at a command by a few per cent. Their average varies
less than each of them (Polyak and Juditsky, 1992).
"""

import math
from dataclasses import dataclass
from typing import Any, cast

import torch
from rsl_rl.algorithms import PPO
from rsl_rl.models import MLPModel
from torch.nn import Module
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

AVERAGE = "average_state_dict"


@dataclass(frozen=True)
class NoiseBound:
    """Greatest standard deviation of the action noise over a training.

    Attributes:
        first, last: at the start and after the last update; between, geometric.
        start: share of the updates from which it falls.
        updates: of the training.
    """

    first: float
    last: float
    start: float
    updates: int

    def after(self, update: int) -> float:
        """The bound after so many updates."""
        begin = self.start * self.updates
        share = (update - begin) / max(self.updates - begin, 1.0)
        return self.first * (self.last / self.first) ** min(max(share, 0.0), 1.0)


class AnnealedPPO(PPO):
    """PPO with bounded action noise and an exponential moving average of the actor.

    Args:
        actor_ema: share of the old average that an update leaves; at 0 the average is the actor.
        noise: bound of the noise over the updates.

    Other arguments are those of rsl-rl's ``PPO``, with a ``log`` standard deviation. The learning
    itself does not see the average.
    """

    def __init__(
        self,
        actor: MLPModel,
        *arguments: Any,
        actor_ema: float,
        noise: NoiseBound,
        **settings: Any,
    ) -> None:
        super().__init__(actor, *arguments, **settings)
        self._noise = noise
        self._average = AveragedModel(
            actor, multi_avg_fn=get_ema_multi_avg_fn(actor_ema), use_buffers=True
        )

    @property
    def averaged_actor(self) -> Module:
        """The average; before the first update the actor itself."""
        return self._average.module if self._average.n_averaged else self.get_policy()

    def update(self) -> dict[str, float]:
        """Update actor and critic, bound the noise, then update the average."""
        losses = super().update()
        actor = self.get_policy()
        bound = self._noise.after(int(self._average.n_averaged) + 1)
        with torch.no_grad():
            cast(Any, actor).distribution.log_std_param.clamp_(max=math.log(bound))
        self._average.update_parameters(actor)
        return losses

    def save(self) -> dict:
        """State of everything, the average included."""
        return {**super().save(), AVERAGE: self._average.state_dict()}

    def load(self, loaded_dict: dict, load_cfg: dict | None, strict: bool) -> bool:
        """As ``PPO.load``; ``average`` in ``load_cfg`` loads the average."""
        if load_cfg is None or load_cfg.get("average"):
            self._average.load_state_dict(loaded_dict[AVERAGE], strict=strict)
        return super().load(loaded_dict, load_cfg, strict)
