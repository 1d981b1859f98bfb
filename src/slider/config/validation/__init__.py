"""Checks of values that types cannot express; one module per part of the configuration.

Each failure is one line. Stages get checked values and need none of this.
"""

from slider.config.schema import Config
from slider.config.validation.ablation import check_ablation
from slider.config.validation.checks import at_least, finite
from slider.config.validation.control import check_controls
from slider.config.validation.env import check_env
from slider.config.validation.evaluation import check_protocols
from slider.config.validation.gait import check_gait
from slider.config.validation.report import check_report
from slider.config.validation.robot import check_robot
from slider.config.validation.seeds import check_seeds
from slider.config.validation.sensitivity import check_sensitivity
from slider.config.validation.train import check_trainings
from slider.config.validation.verification import check_verification


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
    check_report(config.report, config.env.control_period)
    check_ablation(config.ablation)
    check_seeds(config)
    check_sensitivity(config)
    at_least("resources.threads", config.resources.threads, 1)
