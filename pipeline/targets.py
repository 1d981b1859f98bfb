"""All targets, their files, and when these are copied out of the store again.

Studies, the gauge and the search for settings are laid out only when they are asked for, or where
the page shows them: a variant that does not compose, or a policy that is not there, stops no other
target.
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
"""Rules, a target and a part of the page that are no stage."""
ON_DEMAND = {"gauge": gauge_job, "baseline_tuning": baseline_tuning, "second_engine": second_engine}
"""Beside the studies."""


def all_targets(config: Config, overrides: Sequence[str], conf: Path) -> dict[str, JobSpec]:
    """Jobs by the name of their target, of those on demand the ones that the page shows.

    The arguments are those of ``study_job``.

    Raises:
        UserError: there is no such section, a protocol or study has a name that is taken, or the
            page shows a study or the gauge, which cannot be laid out.
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
    """A study or one of ``ON_DEMAND``; the arguments are those of ``study_job``."""
    if name in ON_DEMAND:
        return ON_DEMAND[name](config, targets)
    return study_job(name, config, targets, overrides, conf)


def _check_names(config: Config) -> None:
    """Protocols and studies, which are targets, have names of their own."""
    taken = {*STAGES, *RULES}
    for group, names in (("study", config.study), ("protocols", config.protocols)):
        for name in names:
            expected = "a name that no target, stage or rule has"
            require(name not in taken, f"{group}.{name}", expected, name)
            taken.add(name)


def report_files(config: Config) -> dict[str, tuple[str, ...]]:
    """What people read of each target below the working directory: copies out of the store."""
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

    Their rule has a file as an input that names the plan's recipe. Where reports on disk are other
    ones all the same (edited by hand, or the store was cleaned), their digests are appended:
    Snakemake compares the content of small inputs, so a new modification time alone would not do.
    It sees itself what is missing.
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
