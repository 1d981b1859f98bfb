"""Everything that can be asked for and its files; the ablation too where the page shows it.

Targets of many jobs, ``ON_DEMAND``, are laid out only when somebody asks for them.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from pipeline.ablation import ablation_job
from pipeline.gait_study import NAME as GAIT_STUDY_TARGET
from pipeline.gait_study import gait_study_job
from pipeline.sensitivity import sensitivity_job
from pipeline.stages import all_jobs
from pipeline.stages.entries import ENTRIES
from pipeline.stages.page import needs, report
from slider.artefacts.plan import JobSpec
from slider.config.compose import compose
from slider.config.schema import Config
from slider.config.validation.checks import require
from slider.control import EXPORT_FILES as POLICY_FILES
from slider.reports.figures import FILES as FIGURES
from slider.reports.figures import STABILITY_FILES
from slider.reports.sections.registry import OPTIONAL, PROTOCOLS, SECTIONS, check_sections

ABLATION_TARGET = "ablation"
STUDIES = {
    "seeds": ("ablation=seeds", "ablation.run=[default]"),  # the default alone, from several seeds
    "paper_method": ("ablation=paper_method", "ablation.run=[paper,paper_alive]"),
}
"""Ablations with settings and variants of their own."""
SENSITIVITY_TARGET = "sensitivity"
RULES = ("all", "draw_figures", "gait_library", "policy", "solve_times")
"""Rules that are neither a target nor a stage."""
Targets = Mapping[str, JobSpec]


def all_targets(config: Config, overrides: Sequence[str], conf: Path) -> dict[str, JobSpec]:
    """Jobs by the name of their target; a page without the ablation composes no variant.

    Args:
        config: configuration of the pipeline.
        overrides: with which it was composed.
        conf: folder of the configuration.

    Raises:
        UserError: there is no such section, a protocol has a name that is taken, or the page shows
            the ablation and a variant of it does not compose.
    """
    check_sections(config)
    _check_protocols(config)
    targets = all_jobs(config)
    for name in ON_DEMAND.keys() & {need.partition(".")[0] for need in needs(config)}:
        targets[name] = ON_DEMAND[name](config, targets, overrides, conf)
    return targets | {"report": report(config, targets)}


def _check_protocols(config: Config) -> None:
    """A protocol is a target of its own, and so are its files."""
    shown = (s.needs for name, s in SECTIONS.items() if name not in PROTOCOLS)
    needed = {need.removesuffix(OPTIONAL).partition(".")[0] for needs in shown for need in needs}
    names = {*_files(), *ENTRIES, *RULES, *needed}
    files = {file for files in _files().values() for file in files}
    for name in config.protocols:
        free = name not in names and files.isdisjoint(_compared(name))
        expected = "a name that no target, stage, rule or report has"
        require(free, f"protocols.{name}", expected, name)


def _study(name: str) -> "Lay":
    def lay(config: Config, targets: Targets, overrides: Sequence[str], conf: Path) -> JobSpec:
        own = compose([*overrides, *STUDIES[name]], conf)
        return ablation_job(own, targets["library"], overrides, conf, name)

    return lay


Lay = Callable[[Config, Targets, Sequence[str], Path], JobSpec]
ON_DEMAND: dict[str, Lay] = {
    # The quicker ones to lay out first.
    GAIT_STUDY_TARGET: lambda config, *_: gait_study_job(config),
    SENSITIVITY_TARGET: lambda config, targets, *_: sensitivity_job(config, targets["walking"]),
    ABLATION_TARGET: lambda config, targets, *rest: ablation_job(config, targets["library"], *rest),
    **{name: _study(name) for name in STUDIES},
}
"""Target → its job, from the configuration, the other targets, its overrides and its folder."""


def report_files(config: Config) -> dict[str, tuple[str, ...]]:
    """What people read of each target below the working directory: copies out of the store."""
    files = _files() | {name: _compared(name) for name in config.protocols}
    return {name: tuple(f"reports/{file}" for file in own) for name, own in files.items()}


def _files() -> dict[str, tuple[str, ...]]:
    """Those of every target but the protocols, below ``reports/``."""
    return {
        "table1": ("table1.csv", "gait_quality.csv", "table1.md", "table1.tex"),
        "velocity_tracking": _compared("velocity_tracking"),
        "report": ("index.html",),
        "policy_export": tuple(f"policy/{name}" for name in POLICY_FILES),
        "figures": tuple(f"figures/{name}" for name in FIGURES),
        "verification": ("verification.csv", "verification.json", "verification.md"),
        "stability": ("stability.csv", "stability.md"),
        "stability_figures": tuple(f"figures/{name}" for name in STABILITY_FILES),
        "gait_walks": ("gait_walks.csv", "gait_walks.md"),
        "verification_maps": (*_drawn("verification_maps"), "figures/verification_maps.md"),
        ABLATION_TARGET: (*_compared(ABLATION_TARGET), "ablation_curves.csv"),
        **{name: (*_compared(name), f"{name}_curves.csv") for name in STUDIES},
        SENSITIVITY_TARGET: _compared(SENSITIVITY_TARGET),
        GAIT_STUDY_TARGET: (*_compared(GAIT_STUDY_TARGET), "gait_starts.csv"),
    }


def _compared(name: str) -> tuple[str, ...]:
    """Table and figure of a target that is called as they are."""
    return f"{name}.csv", f"{name}.md", *_drawn(name)


def _drawn(name: str) -> tuple[str, str]:
    return f"figures/{name}.svg", f"figures/{name}.png"
