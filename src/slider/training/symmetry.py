"""Left–right symmetry of a policy: samples and their reflections at the sagittal plane.

rsl-rl either learns from the reflected samples as well or adds a loss on the difference between
the action of a reflected observation and the reflected action (Mittal et al., ICRA 2024).
"""

from typing import Any

import torch
from tensordict import TensorDict

from slider.config.train import PpoConfig
from slider.env.vec_env import WalkingEnv
from slider.robot.names import MIRROR_PERMUTATION, MIRROR_SIGN


def symmetry_config(ppo: PpoConfig) -> dict[str, Any] | None:
    """What rsl-rl's ``symmetry_cfg`` is for a configuration; none where it is off."""
    if ppo.symmetry == "none":
        return None
    return {
        "data_augmentation_func": with_reflections,
        "use_data_augmentation": ppo.symmetry == "augmentation",
        "use_mirror_loss": ppo.symmetry == "loss",
        "mirror_loss_coeff": ppo.symmetry_weight,
    }


def with_reflections(
    env: WalkingEnv, obs: TensorDict | None, actions: torch.Tensor | None
) -> tuple[TensorDict | None, torch.Tensor | None]:
    """Observations (B, size) and actions (B, 12), each followed by its reflection (2 B, ·)."""
    if obs is not None:
        observer = env.agent.observer
        reflected = obs.clone()
        reflected["policy"] = _reflect(obs["policy"], observer.permutation, observer.sign)
        obs = TensorDict.cat([obs, reflected])
    if actions is not None:
        actions = torch.cat([actions, _reflect(actions, MIRROR_PERMUTATION, MIRROR_SIGN)])
    return obs, actions


def _reflect(values: torch.Tensor, permutation: Any, sign: Any) -> torch.Tensor:
    index = torch.as_tensor(permutation, dtype=torch.long, device=values.device)
    return values[:, index] * torch.as_tensor(sign, dtype=values.dtype, device=values.device)
