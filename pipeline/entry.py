"""What the Snakefile is made of: the current plan, the files of its jobs, tracking."""

import os
import shlex
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.rendering import with_renderer
from pipeline.reports import refresh_marker
from pipeline.stages import all_jobs
from slider.core import tracking
from slider.core.config.compose import compose
from slider.core.config.convert import to_dict
from slider.core.config.schema import Config
from slider.core.errors import UserError
from slider.core.plan import Plan, build_plan, write_plan
from slider.core.store import ARTEFACTS, Store
from slider.reports.figures import FILES

OPTION = "hydra"
# What people read, by target: copies out of the store.
REPORTS = {
    "table1": (
        "reports/table1.csv",
        "reports/gait_quality.csv",
        "reports/table1.md",
        "reports/table1.tex",
    ),
    "verification": ("reports/verification.csv", "reports/verification.json"),
    "verification_maps": tuple(
        f"reports/figures/verification_maps.{suffix}" for suffix in ("svg", "png", "md")
    ),
    "figures": tuple(f"reports/figures/{name}" for name in FILES),
    "report": ("reports/index.html",),
}


def protocol_files(name: str) -> tuple[str, ...]:
    """What people read of a protocol beside that of Table 1."""
    table = tuple(f"reports/{name}.{suffix}" for suffix in ("csv", "md"))
    return table + tuple(f"reports/figures/{name}.{suffix}" for suffix in ("svg", "png"))


@dataclass
class Pipeline:
    """The jobs of one configuration, as files below the working directory."""

    config: Config
    overrides: Sequence[str]
    plan: Plan
    plan_path: Path
    store: Store
    session: tracking.Session | None = field(default=None)

    @property
    def run(self) -> str:
        """Shell command that runs a job; the recipe follows."""
        return f"{shlex.quote(sys.executable)} -m slider.cli run --plan {self.plan_path}"

    def manifest(self, target: str) -> str:
        """Manifest of a named target."""
        job = self.plan.jobs[self.plan.targets[target]]
        return str(self.store.manifest_path(job.stage, job.recipe))

    def manifests(self, stage: str) -> list[str]:
        """Manifests of all jobs of a stage."""
        jobs = (job for job in self.plan.jobs.values() if job.stage == stage)
        return [str(self.store.manifest_path(stage, job.recipe)) for job in jobs]

    def inputs(self, wildcards: Any) -> list[str]:
        """Manifests that the job of a recipe needs.

        Raises:
            UserError: the recipe is not of the current plan.
        """
        job = self.plan.jobs.get(wildcards.recipe)
        if job is None:
            raise UserError(f"expected a recipe of the current plan, found {wildcards.recipe}")
        groups = job.inputs.values()
        return [str(self.store.manifest_path(i.stage, i.recipe)) for jobs in groups for i in jobs]

    def start_tracking(self) -> None:
        """Open a session for this pipeline run, if the configuration wants one."""
        artefacts = self.store.root
        tracking.stop(artefacts)
        if not self.config.tracking.enabled:
            return
        info = tracking.SessionInfo(self.config.tracking.experiment, os.getpid(), _git())
        tags = {"plan": self.plan_path.stem, "overrides": " ".join(self.overrides)}
        run = {"name": "pipeline", "tags": tags, "params": to_dict(self.config)}
        self.session = tracking.start(artefacts, info, run)

    def finish_tracking(self, status: str) -> None:
        """Close the session of this pipeline run as ``FINISHED`` or ``FAILED``."""
        if self.session is not None:
            self.session.finish(status)


def open_pipeline(settings: Mapping[str, Any], conf: Path) -> Pipeline:
    """Compose the configuration and lay out its jobs; bad input is one line and status 1."""
    try:
        return _open(_overrides(settings), conf)
    except UserError as error:
        print(f"slider: {error}", file=sys.stderr)
        sys.stderr.flush()
        raise SystemExit(1) from None


def _open(overrides: list[str], conf: Path) -> Pipeline:
    config = with_renderer(compose(overrides, conf))
    store = Store(Path(ARTEFACTS))
    plan = build_plan(all_jobs(config))
    path = write_plan(plan, store.root / "plans")
    os.utime(path)  # `slider store gc` keeps the latest plans
    store.drop_dangling([store.manifest_path(j.stage, j.recipe) for j in plan.jobs.values()])
    reports = REPORTS | {name: protocol_files(name) for name in config.protocols}
    for target, names in reports.items():
        refresh_marker(store, plan, target, [Path(name) for name in names])
    return Pipeline(config, overrides, plan, path, store)


def _overrides(settings: Mapping[str, Any]) -> list[str]:
    unknown = [name for name in settings if name != OPTION]
    if unknown:
        raise UserError(
            f"unknown --config name '{unknown[0]}', expected {OPTION}='key=value ...', "
            "such as --config hydra='gait.cost=torque experiment=paper'"
        )
    text = settings.get(OPTION)
    if text is None:  # not given, or nothing between the quotes
        return []
    if not isinstance(text, str):
        raise UserError(f"--config {OPTION}: expected text of the form key=value, found {text!r}")
    try:
        return shlex.split(text)
    except ValueError as error:
        raise UserError(f"--config {OPTION}: {error} in {text!r}") from None


def _git() -> dict[str, str]:
    """Commit and state of the working tree, where there is one."""
    commit = _ask_git("rev-parse", "HEAD")
    if not commit:
        return {}
    dirty = bool(_ask_git("status", "--porcelain", "--untracked-files=no"))
    return {"mlflow.source.git.commit": commit, "git.dirty": str(dirty).lower()}


def _ask_git(*arguments: str) -> str:
    folder = Path(__file__).parent
    try:
        answer = subprocess.run(
            ["git", *arguments], cwd=folder, capture_output=True, text=True, check=False
        )
    except OSError:  # no git on this machine
        return ""
    return answer.stdout.strip() if answer.returncode == 0 else ""
