"""Checks of values that types cannot express; one module per part of the configuration.

Each failure is one line. Stages get checked values and need none of this.
"""

from slider.core.config.schema import Config
from slider.core.config.validation.ablation import check_ablation
from slider.core.config.validation.checks import at_least, finite
from slider.core.config.validation.control import check_controls
from slider.core.config.validation.env import check_env
from slider.core.config.validation.evaluation import check_protocols
from slider.core.config.validation.gait import check_gait
from slider.core.config.validation.report import check_report
from slider.core.config.validation.robot import check_robot
from slider.core.config.validation.seeds import check_seeds
from slider.core.config.validation.sensitivity import check_sensitivity
from slider.core.config.validation.train import check_trainings
from slider.core.config.validation.verification import check_verification


def validate(config: Config) -> None:
    """Refuse impossible values.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    finite("", config)
    check_robot(config.robot)
    check_gait(config.gait)
    check_env(config.env)
    check_trainings(config.train, config.finetuning, config.env)
    check_controls(config.control, config.env)
    check_protocols(config)
    check_verification(config.verification)
    check_report(config.report, config.protocols, config.env.control_period)
    check_ablation(config.ablation)
    check_seeds(config)
    check_sensitivity(config)
    at_least("resources.threads", config.resources.threads, 1)
