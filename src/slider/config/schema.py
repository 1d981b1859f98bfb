"""Root of the typed configuration."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.control import AnyControl
from slider.config.env import EnvConfig
from slider.config.evaluation import EvaluationConfig, SeedsConfig, SpeedsConfig
from slider.config.gait import GaitConfig, LibraryConfig
from slider.config.hzd import HzdConfig
from slider.config.report import ReportConfig
from slider.config.robot import RobotConfig
from slider.config.studies import StudyConfig
from slider.config.train import TrainConfig, TrainingsConfig
from slider.config.types import STRICT, Count, Name
from slider.config.verification import VerificationConfig


@dataclass(frozen=True, config=STRICT)
class TrackingConfig:
    """MLflow."""

    enabled: bool
    """false: no MLflow run is written"""
    experiment: Name
    """name of the MLflow experiment"""


@dataclass(frozen=True, config=STRICT)
class StoreConfig:
    """The store of results. Never part of a recipe."""

    remote: Name | None
    """where missing results are taken from: a folder, ``s3://…``, ``sftp://…``, ``https://…``"""


@dataclass(frozen=True, config=STRICT)
class ResourcesConfig:
    """Of the machine that computes. Never part of a recipe."""

    threads: Annotated[Count, Field(le=1024)] | None
    """cores of a training (other jobs have one); null: one, and idle ones beside it"""


@dataclass(frozen=True, config=STRICT)
class Config:
    """Root of the configuration; one field per group of ``conf/``.

    ``control`` holds the controllers beside the policy, by the name that evaluations have for them.
    ``evaluation`` is the protocol of Table 1; ``protocols`` are others, each with its own report.
    ``finetuning`` goes on from the walking policy; its result is then the policy.
    """

    speeds: SpeedsConfig  # first: a mistake in it is found here, not where it is referred to
    robot: RobotConfig
    gait: GaitConfig
    library: LibraryConfig
    hzd: HzdConfig
    env: EnvConfig
    train: TrainingsConfig
    control: dict[str, AnyControl]
    seeds: SeedsConfig
    evaluation: EvaluationConfig
    protocols: dict[str, EvaluationConfig]
    verification: VerificationConfig
    report: ReportConfig
    study: dict[str, StudyConfig]
    tracking: TrackingConfig
    store: StoreConfig
    resources: ResourcesConfig
    finetuning: TrainConfig | None = None

    @property
    def evaluations(self) -> dict[str, EvaluationConfig]:
        """Protocols by their keys."""
        others = {f"protocols.{name}": protocol for name, protocol in self.protocols.items()}
        return {"evaluation": self.evaluation, **others}

    @property
    def trainings(self) -> dict[str, TrainConfig]:
        """Trainings by their keys."""
        # Values of the standing training refer to the walking training: mistakes are found there.
        found = {"train.walking": self.train.walking, "train.standing": self.train.standing}
        return found | ({"finetuning": self.finetuning} if self.finetuning else {})
