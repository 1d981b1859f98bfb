"""Everything that can be asked for, the page among it; the ablation where the page shows it.

Targets of many jobs, ``ON_DEMAND``, are laid out only when somebody asks for them.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from pipeline.ablation import ablation_job
from pipeline.sensitivity import sensitivity_job
from pipeline.stages import all_jobs
from pipeline.stages.page import report
from slider.artefacts.plan import JobSpec
from slider.config.compose import compose
from slider.config.report import SECTION_INPUTS
from slider.config.schema import Config

ABLATION_TARGET = "ablation"
SEEDS_TARGET = "seeds"  # the ablation of the default alone, from several seeds
SENSITIVITY_TARGET = "sensitivity"
Targets = Mapping[str, JobSpec]


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


def _ablation(config: Config, targets: Targets, overrides: Sequence[str], conf: Path) -> JobSpec:
    return ablation_job(config, targets["library"], overrides, conf)


def _seeds(config: Config, targets: Targets, overrides: Sequence[str], conf: Path) -> JobSpec:
    own = compose([*overrides, "ablation=seeds", "ablation.run=[default]"], conf)
    return ablation_job(own, targets["library"], overrides, conf, SEEDS_TARGET)


def _sensitivity(config: Config, targets: Targets, overrides: Sequence[str], conf: Path) -> JobSpec:
    return sensitivity_job(config, targets["walking"])


ON_DEMAND: dict[str, Callable[[Config, Targets, Sequence[str], Path], JobSpec]] = {
    SENSITIVITY_TARGET: _sensitivity,  # the quicker one to lay out first
    ABLATION_TARGET: _ablation,
    SEEDS_TARGET: _seeds,
}
"""Target → its job, from the configuration, the other targets, its overrides and its folder."""
