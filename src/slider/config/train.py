"""Typed settings of the trainings."""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import Field

from slider.config import types as t
from slider.config.env import DisturbanceConfig, Sensing

WARP = "slider.env.warp"
"""Module of MuJoCo Warp's physics; its code is in the section of the trainings that use it."""


class VelocitiesConfig(t.Group):
    """Ranges from which commanded velocities are drawn uniformly, and how often they change."""

    vx: t.Interval[t.MetresPerSecond]
    vy: t.Interval[t.MetresPerSecond]
    yaw_rate: t.Interval[t.RadiansPerSecond]
    period: t.Seconds
    """mean time between changes; 0: never within an episode"""
    standing_fraction: t.Share
    """share of commands that are zero: stand"""
    uneven: Annotated[t.Share, Field(gt=0)]
    """factor on the drawn velocities where the terrain is not flat"""


class GuideConfig(t.Group):
    """Which reference gait is used for a velocity between those of the library."""

    gait: Literal["interpolated", "nearest"]
    """interpolate the library at the reference velocity, or take its nearest gait"""


class RewardTerm(t.Group):
    """Weight of a reward term and its parameters."""

    weight: t.Number
    """factor on the term; 0 switches it off"""
    params: dict[str, float] = field(default_factory=dict)
    """parameter of the term; the term defines its bounds"""


class RewardConfig(t.Group):
    """max(weighted sum of terms, ``floor``) · ``scale`` + ``on_fall``."""

    terms: Annotated[dict[str, RewardTerm], Field(min_length=1)]
    scale: t.Positive[t.Number]
    """factor on the sum of the terms"""
    floor: t.Number
    """lower bound of the sum, before ``scale``"""
    on_fall: t.Number
    """added when the episode ends in a fall"""

    @property
    def active(self) -> dict[str, RewardTerm]:
        """Terms with a nonzero weight."""
        return {name: term for name, term in self.terms.items() if term.weight != 0}


class ResetConfig(t.Group):
    """How episodes start."""

    reference_fraction: t.Share
    """share of episodes that start from a state of the reference gait; the others start at rest"""


class NetworkConfig(t.Group):
    """Actor and critic: multilayer perceptrons of the same shape; the action noise is learned."""

    hidden: t.Some[Annotated[t.Count, Field(le=65536)]]
    """widths of the hidden layers, the same for actor and critic"""
    activation: Literal["elu", "relu", "tanh"]
    """activation of the hidden layers"""
    initial_std: t.Positive[t.Factor]
    """initial standard deviation of the action noise"""
    std_min: t.Positive[t.Factor]
    """lower bound of the action standard deviation"""
    std_max: t.Positive[t.Factor]
    """upper bound of the action standard deviation"""
    std_final: t.Positive[t.Factor]
    """upper bound of the action standard deviation at the end of the training"""
    anneal_from: t.Positive[t.Share]
    """share of the iterations after which the upper bound decays geometrically to std_final"""
    output_scale: t.Positive[t.Factor]
    """factor on the last layer's initial weights: small first actions"""


class PpoConfig(t.Group):
    """Proximal policy optimisation with generalised advantage estimation."""

    learning_rate: t.Positive[t.Factor]
    """learning rate; with the adaptive schedule, its initial value"""
    schedule: Literal["adaptive", "fixed"]
    """learning rate schedule; adaptive: follow desired_kl"""
    desired_kl: t.Positive[t.Factor]
    """target KL divergence per update of the adaptive schedule"""
    epochs: Annotated[t.Count, Field(le=1000)]
    """passes over the samples of an update"""
    mini_batches: t.Count
    """mini-batches per epoch"""
    clip: t.Positive[t.Factor]
    """clipping range of the probability ratio and of the value"""
    gamma: t.Positive[t.Share]
    """discount per control step"""
    lam: t.Share
    """λ of the generalised advantage estimate"""
    value_coefficient: t.Factor
    """weight of the value loss"""
    entropy_coefficient: t.Factor
    """weight of the entropy bonus"""
    max_grad_norm: t.Positive[t.Number]
    """gradients are clipped to this norm"""
    precision: Literal["auto", "float32", "bfloat16"]
    """precision of updates; auto: bfloat16 if the CPU supports it, resolved at planning time"""
    actor_ema: Annotated[t.Share, Field(lt=1)]
    """decay of the actor's moving average per update; this average is evaluated and exported"""


class SelectionConfig(t.Group):
    """Periodic small evaluation that picks the checkpoint to keep."""

    interval: t.Count
    """iterations between checks; at a check a checkpoint is written and all robots are reset"""
    speeds: t.Distinct[t.Some[t.MetresPerSecond]]
    """forward velocities of the checks"""
    robots: t.Count
    """robots per speed"""
    seed: t.Seed
    """seed of the initial states, which are the same in every check"""
    duration: t.Positive[t.Seconds]
    warm_up: t.Seconds
    """initial part of a rollout that is excluded from the error"""
    fall_weight: t.Positive[t.Number]
    """cost of a robot that fell; that of a surviving robot is always less than half of it"""


class TrainConfig(t.Group):
    """One training run."""

    iterations: Annotated[int, Field(ge=0, le=10_000_000)]
    """updates; samples = iterations × robots × steps_per_iteration"""
    simulator: Literal["mujoco", "mujoco_warp"]
    """mujoco: on the CPU; mujoco_warp: all robots in parallel on ``device`` (needs extra gpu)"""
    device: Literal["cpu", "cuda", "auto"]
    """device of physics and networks; auto: cuda if available, resolved at planning time"""
    robots: t.Count
    """robots simulated in parallel"""
    steps_per_iteration: Annotated[t.Count, Field(le=100_000)]
    """control steps of each robot between updates"""
    episode_length: t.Positive[t.Seconds]
    """time after which an episode ends and the robot is reset"""
    seed: t.Seed
    """seed of networks, environments and noise"""
    velocities: VelocitiesConfig
    guide: GuideConfig
    reward: RewardConfig
    reset: ResetConfig
    network: Annotated[
        NetworkConfig, t.ordered("std_min", "std_max"), t.ordered("std_min", "std_final")
    ]
    ppo: PpoConfig
    selection: SelectionConfig
    disturbance: DisturbanceConfig
    sensing: Sensing
    """state that the policy receives: the true one, or the estimate from onboard sensors"""

    def __post_init__(self) -> None:
        simulator, batch = self.simulator, self.robots * self.steps_per_iteration
        flat = self.disturbance.terrain.kinds == ["flat"] and self.sensing == "true_state"
        expected = "mujoco with disturbance.terrain or sensing=onboard"
        t.require(flat or simulator == "mujoco", "simulator", expected, simulator)
        possible = simulator == "mujoco_warp" or self.device == "cpu"
        t.require(possible, "device", f"cpu with simulator={simulator}", self.device)
        expected = "at least 2 samples (robots × steps_per_iteration)"
        t.require(batch > 1, "robots", expected, batch)
        expected, found = f"1 to {batch} (robots × steps_per_iteration)", self.ppo.mini_batches
        t.require(found <= batch, "ppo.mini_batches", expected, found)


class TrainingsConfig(t.Group):
    """Standing pre-training, then walking."""

    pretraining: bool
    """walking starts from the standing policy; false: from scratch"""
    standing: TrainConfig
    walking: TrainConfig

    def __post_init__(self) -> None:
        starts, key = self.standing.reset.reference_fraction, "standing.reset.reference_fraction"
        t.require(starts == 0, key, "0 (pre-training has no guide to start on)", starts)
        for name in ("hidden", "activation") if self.pretraining else ():
            own, found = (getattr(x.network, name) for x in (self.walking, self.standing))
            expected = f"{own}, as train.walking.network has it"
            t.require(found == own, f"standing.network.{name}", expected, found)
