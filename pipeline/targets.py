"""Everything that can be asked for, the page among it; and the ablation where the page shows it."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.ablation import ablation_job
from pipeline.stages import all_jobs
from pipeline.stages.page import report
from slider.core.config.report import SECTION_INPUTS
from slider.core.config.schema import Config
from slider.core.plan import JobSpec

ABLATION_TARGET = "ablation"


def all_targets(config: Config, overrides: Sequence[str], conf: Path) -> dict[str, JobSpec]:
    """Jobs by the name of their target; a page without the ablation composes no variant.

    Args:
        config: configuration of the pipeline.
        overrides: with which it was composed.
        conf: folder of the configuration.

    Raises:
        UserError: the page shows the ablation, and a variant does not compose.
    """
    targets = all_jobs(config)
    needed = {name for section in config.report.sections for name in SECTION_INPUTS[section]}
    if ABLATION_TARGET in needed:
        job = ablation_job(config, targets["library"], overrides, conf)
        targets[ABLATION_TARGET] = job
    return targets | {"report": report(config, targets)}
