"""Root of the typed configuration, and groups that are not the section of a stage."""

from dataclasses import field
from typing import Annotated

from pydantic import Field

from slider.config import types as t
from slider.config.control import POLICY, Controls
from slider.config.env import EnvConfig
from slider.config.evaluation import (
    EvaluationConfig,
    GaugeConfig,
    ReportConfig,
    SecondEngineConfig,
    SeedsConfig,
    SpeedsConfig,
    TuningConfig,
)
from slider.config.gait import GaitConfig, LibraryConfig, StartSpread, VerificationConfig
from slider.config.hzd import HzdConfig
from slider.config.robot import Provenance, RobotConfig
from slider.config.train import TrainConfig, TrainingsConfig

Samples = Annotated[int, Field(ge=1, le=1_000_000_000_000)]


class VariantConfig(t.Group):
    """One row of a study: its display name and its Hydra overrides."""

    label: t.Name
    """name in table and figure"""
    overrides: list[t.Name]
    """Hydra overrides of the configuration that the pipeline was started with"""


class ScalingConfig(t.Group):
    """Further variants: parameters of the robot, scaled one at a time by two factors."""

    change: Annotated[t.Share, Field(gt=0, lt=1)]
    """relative change: the factors are 1 − change and 1 + change"""
    provenance: t.Distinct[t.Some[Provenance]]
    """provenance tags of the parameters that vary"""
    parameters: list[t.Name]
    """dotted names below robot, or groups of them; empty: all with these tags"""


class StartsConfig(t.Group):
    """Random initial guesses for each gait, solved independently."""

    count: t.Count
    """number of guesses per variant and speed"""
    seed: t.Seed
    """seed of the guesses; guess k is the same at every speed and for every ``count``"""
    same_cost: t.Tolerance
    """relative difference of cost up to which two solutions count as one optimum"""
    spread: StartSpread


class BudgetConfig(t.Group):
    """Trainings of each variant, with the same budget for all."""

    seeds: t.Distinct[t.Some[t.Seed]]
    """training seeds; one training (standing and walking) per seed"""
    samples: Samples
    """environment steps of a walking training"""
    pretraining_samples: Samples
    """environment steps of a standing training, if there is one"""
    check_every: Samples
    """environment steps between checks, which are the points of the learning curves"""


class RolloutsConfig(t.Group):
    """Evaluations of each variant; all other settings are those of ``evaluation``."""

    trials: Annotated[t.Count, Field(le=100_000)]
    """number of trials, each with its own seed"""
    robots: t.Count
    """robots per trial"""
    seed: t.Seed
    """seed of the first trial"""
    controllers: t.Distinct[t.Some[t.Name]] = field(default_factory=lambda: [POLICY])
    """evaluated controllers, with the variant's gaits; each except the policy has its own row"""


class StudyConfig(t.Group):
    """Variants and the metrics that are compared; ``conf/study/NAME.yaml`` is the target NAME."""

    run: t.Distinct[t.Some[t.Name]]
    """variants that are compared, in this order; the first one is the reference"""
    variants: t.Named[VariantConfig]
    speeds: t.Distinct[t.Some[t.MetresPerSecond]]
    """forward velocities of gaits and evaluations"""
    metrics: t.Distinct[t.Some[t.Name]]
    """columns of NAME_runs.csv that are compared; the figure has the first five"""
    scaling: ScalingConfig | None = None
    """further variants; null: none"""
    gaits: bool = False
    """solve the gaits of each variant"""
    starts: StartsConfig | None = None
    """also solve them from random initial guesses; null: no"""
    training: BudgetConfig | None = None
    """train each variant; null: the pipeline's policy, not retrained, on each variant's robot"""
    evaluation: RolloutsConfig | None = None
    """evaluate each variant; null: no"""

    def __post_init__(self) -> None:
        t.require(self.gaits or self.evaluation, "", "gaits=true or an evaluation")
        t.require(self.gaits or not self.starts, "", "starts: null without gaits")
        possible = self.evaluation or not self.training
        t.require(possible, "", "training: null without an evaluation")
        for name in self.run:
            t.require(name in self.variants, "run", f"one of {', '.join(self.variants)}", name)


class TrackingConfig(t.Group):
    """Experiment tracking with MLflow."""

    enabled: bool
    """false: no MLflow run is written"""
    experiment: t.Name
    """name of the MLflow experiment"""


class StoreConfig(t.Group):
    """The store of results. Never part of a recipe."""

    remote: t.Name | None
    """source of missing results: a folder, ``s3://…``, ``sftp://…`` or ``https://…``; null: none"""


class ResourcesConfig(t.Group):
    """Resources of the machine that runs the jobs. Never part of a recipe."""

    threads: Annotated[t.Count, Field(le=1024)] | None
    """cores per training (other jobs have one); null: one, plus cores that are idle"""


class Config(t.Group):
    """Root of the configuration; one field per group of ``conf/``.

    ``control`` holds the controllers other than the policy, by the name used in evaluations.
    ``evaluation`` is the protocol of Table 1; ``protocols`` are others, each with its own report.
    ``finetuning`` continues training from the walking policy; its result is then the policy.
    """

    speeds: SpeedsConfig  # first: an error in it is reported here, not where it is referred to
    robot: RobotConfig
    gait: GaitConfig
    library: LibraryConfig
    hzd: HzdConfig
    env: EnvConfig
    train: TrainingsConfig
    control: Controls
    seeds: SeedsConfig
    evaluation: EvaluationConfig
    protocols: t.Named[EvaluationConfig]
    second_engine: SecondEngineConfig
    gauge: GaugeConfig
    tuning: TuningConfig
    verification: VerificationConfig
    report: ReportConfig
    study: t.Named[StudyConfig]
    tracking: TrackingConfig
    store: StoreConfig
    resources: ResourcesConfig
    finetuning: TrainConfig | None = None

    @property
    def evaluations(self) -> dict[str, EvaluationConfig]:
        """Protocols by their keys."""
        others = {f"protocols.{name}": protocol for name, protocol in self.protocols.items()}
        others["second_engine.protocol"] = self.second_engine.protocol
        return {"evaluation": self.evaluation, **others}

    @property
    def trainings(self) -> dict[str, TrainConfig]:
        """Trainings by their keys."""
        # Values of the standing training refer to the walking training: mistakes are found there.
        trainings = {"train.walking": self.train.walking, "train.standing": self.train.standing}
        return trainings | ({"finetuning": self.finetuning} if self.finetuning else {})
