"""All targets, their report files, and when these must be copied from the store again.

Jobs of studies, gauge, second engine and hyperparameter search are created only on request, or if
the page shows them: an invalid variant or a missing policy does not affect other targets.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

from pipeline.stages import all_jobs
from pipeline.stages.entries import STAGES, compared, tables
from pipeline.stages.evaluation import baseline_tuning, gauge_job, second_engine
from pipeline.stages.page import needs, report
from pipeline.studies import study_job
from slider.artefacts.manifest import readable
from slider.artefacts.plan import JobSpec, Plan
from slider.artefacts.store import Store
from slider.config.schema import Config
from slider.core import files
from slider.core.errors import require
from slider.reports.sections import check_sections

RULES = ("all", "draw_figures", "gait_library", "policy", "untuned", "videos")
"""Reserved names of rules, of a target and of a part of the page that are not stages."""
ON_DEMAND = {"gauge": gauge_job, "baseline_tuning": baseline_tuning, "second_engine": second_engine}
"""Targets on demand other than studies."""


def all_targets(config: Config, overrides: Sequence[str], conf: Path) -> dict[str, JobSpec]:
    """Jobs by the name of their target; targets on demand are included if the page shows them.

    The arguments are those of ``study_job``.

    Raises:
        UserError: a section of the page does not exist, the name of a protocol or study is taken,
            or the page shows a target on demand whose jobs cannot be created.
    """
    check_sections(config)
    _check_names(config)
    targets = all_jobs(config)
    needed = {need.partition(".")[0] for need in needs(config)}
    for name in (name for name in (*config.study, *ON_DEMAND) if name in needed):
        targets[name] = job_on_demand(name, config, targets, overrides, conf)
    return targets | {"report": report(config, targets)}


def job_on_demand(
    name: str, config: Config, targets: Mapping[str, JobSpec], overrides: Sequence[str], conf: Path
) -> JobSpec:
    """Job of a study or of one of ``ON_DEMAND``; the arguments are those of ``study_job``."""
    if name in ON_DEMAND:
        return ON_DEMAND[name](config, targets)
    return study_job(name, config, targets, overrides, conf)


def _check_names(config: Config) -> None:
    """Check that names of protocols and studies, which are targets, are unique."""
    taken = {*STAGES, *RULES}
    for group, names in (("study", config.study), ("protocols", config.protocols)):
        for name in names:
            expected = "a name that no target, stage or rule has"
            require(name not in taken, f"{group}.{name}", expected, name)
            taken.add(name)


def report_files(config: Config) -> dict[str, tuple[str, ...]]:
    """Report files of each target below the working directory: copies of files of the store."""
    files = {name: stage.files for name, stage in STAGES.items() if stage.files}
    for name, protocol in config.protocols.items():
        drawn = protocol.profile is None or protocol.profile.rows != "cases"
        files[name] = compared(name) if drawn else tables(name)
    for name, study in config.study.items():  # learning curves where it trains
        drawn = study.training is not None
        curves = [f"{name}_curves.csv"] * drawn
        files[name] = (*(compared if drawn else tables)(name), f"{name}_runs.csv", *curves)
    return {name: tuple(f"reports/{file}" for file in own) for name, own in files.items()}


def refresh_marker(store: Store, plan: Plan, target: str, reports: Sequence[Path]) -> None:
    """Make reports look outdated exactly when they are not those of the current plan.

    An input of their rule is a marker file with the recipe in the plan. If reports on disk differ
    from it all the same (edited by hand, or the store was cleaned), their digests are appended:
    Snakemake compares the content of small inputs, so a new modification time is not sufficient.
    Snakemake itself detects missing reports.
    """
    recipe, path = plan.targets[target], store.root / "current" / target
    words = path.read_text("utf-8", "replace").split() if path.is_file() else []
    manifest = readable(store.manifest_path(plan.jobs[recipe].stage, recipe))
    table = manifest.result.files if manifest else {}
    digests = {report.name: files.digest_file(report) for report in reports if report.is_file()}
    own = {name: entry.sha256 for name, entry in table.items()}
    others = [digest for name, digest in digests.items() if digest != own.get(name)]
    expected = [recipe, *others]
    if words != expected and (others or words[:1] != [recipe]):
        files.write_atomic(path, "\n".join(expected) + "\n")
