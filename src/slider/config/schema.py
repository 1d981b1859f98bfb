"""Root of the typed configuration, and the groups that no stage takes as its section."""

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
    """One row of a study: its name for people, and Hydra overrides of the configuration."""

    label: t.Name
    """name in table and figure"""
    overrides: list[t.Name]
    """of the configuration that the pipeline was given"""


class ScalingConfig(t.Group):
    """Further variants: numbers of the robot, each multiplied by two factors, one at a time."""

    change: Annotated[t.Share, Field(gt=0, lt=1)]
    """the factors are 1 − this and 1 + this"""
    provenance: t.Distinct[t.Some[Provenance]]
    """tags of the numbers that vary"""
    parameters: list[t.Name]
    """dotted names below robot, or groups of them; empty: all with these tags"""


class StartsConfig(t.Group):
    """Random initial guesses of each gait, each solved by itself."""

    count: t.Count
    """per variant and speed"""
    seed: t.Seed
    """start k is the same at every speed, however many there are"""
    same_cost: t.Tolerance
    """relative difference of cost up to which two solutions count as one optimum"""
    spread: StartSpread


class BudgetConfig(t.Group):
    """Trainings of each variant, the same length for all."""

    seeds: t.Distinct[t.Some[t.Seed]]
    """of standing and walking; one training each"""
    samples: Samples
    """control steps of a robot, of a walking training"""
    pretraining_samples: Samples
    """of a standing training, where there is one"""
    check_every: Samples
    """samples between checks: the points of the learning curves"""


class RolloutsConfig(t.Group):
    """Evaluations of each variant; all else is as in ``evaluation``."""

    trials: Annotated[t.Count, Field(le=100_000)]
    """each with a seed of its own"""
    robots: t.Count
    """per trial"""
    seed: t.Seed
    """of the first trial"""
    controllers: t.Distinct[t.Some[t.Name]] = field(default_factory=lambda: [POLICY])
    """each but the policy has a row of its own; baselines walk the gaits of the variant"""


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
    """solve them from random guesses too; null: not"""
    training: BudgetConfig | None = None
    """train each variant; null: the pipeline's policy, not retrained, on each variant's robot"""
    evaluation: RolloutsConfig | None = None
    """evaluate each variant; null: not"""

    def __post_init__(self) -> None:
        t.require(self.gaits or self.evaluation, "", "gaits=true or an evaluation")
        t.require(self.gaits or not self.starts, "", "starts: null without gaits")
        possible = self.evaluation or not self.training
        t.require(possible, "", "training: null without an evaluation")
        for name in self.run:
            t.require(name in self.variants, "run", f"one of {', '.join(self.variants)}", name)


class TrackingConfig(t.Group):
    """MLflow."""

    enabled: bool
    """false: no MLflow run is written"""
    experiment: t.Name
    """name of the MLflow experiment"""


class StoreConfig(t.Group):
    """The store of results. Never part of a recipe."""

    remote: t.Name | None
    """where missing results are taken from: a folder, ``s3://…``, ``sftp://…``, ``https://…``"""


class ResourcesConfig(t.Group):
    """Of the machine that computes. Never part of a recipe."""

    threads: Annotated[t.Count, Field(le=1024)] | None
    """cores of a training (other jobs have one); null: one, and idle ones beside it"""


class Config(t.Group):
    """Root of the configuration; one field per group of ``conf/``.

    ``control`` holds the controllers beside the policy, by the name that evaluations have for them.
    ``evaluation`` is the protocol of Table 1; ``protocols`` are others, each with its own report.
    ``finetuning`` goes on from the walking policy; its result is then the policy.
    """

    speeds: SpeedsConfig  # first: a mistake in it is reported here, not where it is referred to
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
