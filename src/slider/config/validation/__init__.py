"""Rules between values; what a value may be by itself is in the types of the schema.

Each failure is one line. Stages get checked values and need none of this.
"""

from slider.config.schema import Config
from slider.config.validation.control import check_controls
from slider.config.validation.env import check_env
from slider.config.validation.evaluation import check_protocols
from slider.config.validation.gait import check_gait, check_regulator
from slider.config.validation.reports import check_report
from slider.config.validation.robot import check_robot
from slider.config.validation.seeds import check_seeds
from slider.config.validation.studies import check_studies
from slider.config.validation.train import check_trainings


def validate(config: Config) -> None:
    """Refuse values that do not fit together.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    check_robot(config.robot)
    check_gait(config.gait)
    check_env(config.env)
    check_trainings(config)
    check_controls(config.control, config.env)
    check_protocols(config)
    check_regulator(config.verification.replay.regulator)
    check_report(config.report, config.env.control_period)
    check_seeds(config)
    check_studies(config)
