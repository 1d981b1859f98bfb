"""Root of the typed configuration."""

from pydantic.dataclasses import dataclass

from slider.core.config.ablation import AblationConfig
from slider.core.config.control import ControlConfig
from slider.core.config.env import EnvConfig
from slider.core.config.evaluation import EvaluationConfig, ResourcesConfig, TrackingConfig
from slider.core.config.gait import GaitConfig, LibraryConfig
from slider.core.config.report import ReportConfig
from slider.core.config.robot import RobotConfig
from slider.core.config.seeds import SeedsConfig
from slider.core.config.sensitivity import SensitivityConfig
from slider.core.config.strict import STRICT
from slider.core.config.train import TrainConfig, TrainingsConfig
from slider.core.config.verification import VerificationConfig


@dataclass(frozen=True, config=STRICT)
class Config:
    """Root of the configuration; one field per group of ``conf/``.

    ``evaluation`` is the protocol of Table 1; ``protocols`` are others, each with its own report.
    ``finetuning`` goes on from the walking policy; its result is then the policy.
    """

    robot: RobotConfig
    gait: GaitConfig
    library: LibraryConfig
    env: EnvConfig
    train: TrainingsConfig
    control: ControlConfig
    seeds: SeedsConfig
    evaluation: EvaluationConfig
    protocols: dict[str, EvaluationConfig]
    verification: VerificationConfig
    report: ReportConfig
    ablation: AblationConfig
    sensitivity: SensitivityConfig
    tracking: TrackingConfig
    resources: ResourcesConfig
    finetuning: TrainConfig | None = None
