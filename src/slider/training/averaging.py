"""PPO that also keeps a moving average of the actor: what is judged, kept and exported.

Single updates push the mean speed at a command to and fro by a few per cent; their average is
steadier than each of them (Polyak and Juditsky, 1992).
"""

from typing import Any

from rsl_rl.algorithms import PPO
from rsl_rl.models import MLPModel
from torch.nn import Module
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

AVERAGE = "average_state_dict"


class AveragingPPO(PPO):
    """PPO with an exponential moving average of the actor over its updates.

    Args:
        averaging: share of the old average that an update leaves; at 0 the average is the actor.

    Other arguments are those of rsl-rl's ``PPO``. The learning itself does not see the average.
    """

    def __init__(self, actor: MLPModel, *arguments: Any, averaging: float, **settings: Any) -> None:
        super().__init__(actor, *arguments, **settings)
        self._average = AveragedModel(
            actor, multi_avg_fn=get_ema_multi_avg_fn(averaging), use_buffers=True
        )

    @property
    def averaged_actor(self) -> Module:
        """The average; before the first update the actor itself."""
        return self._average.module if self._average.n_averaged else self.get_policy()

    def update(self) -> dict[str, float]:
        """Update actor and critic, then the average."""
        losses = super().update()
        self._average.update_parameters(self.get_policy())
        return losses

    def save(self) -> dict:
        """State of everything, the average included."""
        return {**super().save(), AVERAGE: self._average.state_dict()}

    def load(self, loaded_dict: dict, load_cfg: dict | None, strict: bool) -> bool:
        """As ``PPO.load``; ``average`` in ``load_cfg`` asks for the average."""
        if load_cfg is None or load_cfg.get("average"):
            self._average.load_state_dict(loaded_dict[AVERAGE], strict=strict)
        return super().load(loaded_dict, load_cfg, strict)
