"""What the Snakefile is made of: the current plan, the files of its jobs, tracking."""

import gc
import getpass
import os
import shlex
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.stages.page import with_renderer
from pipeline.targets import all_targets, job_on_demand, refresh_marker, report_files
from slider.artefacts.maintenance import date_now, drop_damaged
from slider.artefacts.plan import JobSpec, Plan, build_plan, plan_path, read_plan, write_plan
from slider.artefacts.remote import Remote
from slider.artefacts.run_metadata import note_start, revision
from slider.artefacts.sharing import pull
from slider.artefacts.store import ARTEFACTS, Store
from slider.config.compose import compose
from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.core import environment
from slider.core.errors import UserError, is_read_only, not_written
from slider.core.machine import MOST_THREADS, training_threads
from slider.env.terms import checked
from slider.tracking import journal as tracking
from slider.tracking.journal import FAILED, FINISHED

OPTION, PLAN = "hydra", "plan"  # of --config; the latter is the head's word to its jobs
_TITLE = 80  # characters
_TAGS = {"commit": "mlflow.source.git.commit", "dirty": "git.dirty"}  # MLflow shows the first


@contextmanager
def one_line() -> Iterator[None]:
    """End the process with one line and status 1 where the input is bad or a file cannot be."""
    try:
        yield
    except (UserError, OSError) as error:
        line: object = error
        if isinstance(error, OSError):
            place = f"{error.filename2 or error.filename}: {error.strerror}"
            line = not_written(error, Path(ARTEFACTS)) or place
        print(f"slider: {line}", file=sys.stderr, flush=True)
        raise SystemExit(1) from None


@dataclass
class Pipeline:
    """The jobs of one configuration, as files below the working directory.

    ``cores`` are those that all jobs share; ``None`` on a cluster, where each has its own.
    """

    config: Config
    overrides: Sequence[str]
    plan: Plan
    plan_path: Path
    store: Store
    conf: Path
    cores: int | None = None
    session: tracking.Session | None = field(default=None)

    @property
    def reports(self) -> dict[str, tuple[str, ...]]:
        """Files that people read, by target."""
        return report_files(self.config)

    @property
    def run(self) -> str:
        """Shell command that runs a job; the recipe follows."""
        return f"{self.slider} run --plan {self.plan_path}"

    @property
    def slider(self) -> str:
        """Shell command ``slider`` in the environment of a job.

        glibc reads variables when a process starts: they could hide instructions of the
        processor, or put other functions in the place of the mathematical library's.
        """
        words = (sys.executable, "-I", "-X", "utf8", environment.__file__)
        folders = environment.library_path(os.environ.get("LD_LIBRARY_PATH", ""))
        loader = f"GLIBC_TUNABLES= LD_PRELOAD= LD_LIBRARY_PATH={shlex.quote(folders)}"
        return f"{loader} {shlex.join(words)}"

    def slots(self, wildcards: Any) -> int:
        """Cores that the training of a recipe holds: no fewer than its processes, one for each GPU.

        They are ``resources.threads``. A job of several waits until as many are free at once, so
        the default is one, but on a cluster, where the scheduler gives them at once.
        """
        wanted = self.config.resources.threads or (1 if self.cores else MOST_THREADS)
        return max(wanted, self.gpus(wildcards))

    def threads(self, slots: int) -> int:
        """Threads of a training that holds some slots.

        By default its physics runs on more, which use the cores that other jobs leave idle.
        """
        if self.cores is None or self.config.resources.threads is not None:
            return slots
        return max(slots, training_threads(self.cores))

    def gpus(self, wildcards: Any) -> int:
        """GPUs that the job of a recipe needs."""
        train = self.plan.jobs[wildcards.recipe].section["train"]
        return train["gpus"] if train["device"] == "cuda" else 0

    def manifest(self, target: str) -> Callable[[Any], str]:
        """Input function: the manifest of a target, whose jobs join the plan if they are not in it.

        A target that cannot be laid out is one line and status 1.
        """

        def find(wildcards: Any) -> str:
            if target not in self.plan.targets:
                with one_line():
                    self._plan_also(target)
            return self._manifest(self.plan.jobs[self.plan.targets[target]])

        return find

    def inputs(self, wildcards: Any) -> list[str]:
        """Manifests that the job of a recipe needs.

        Raises:
            UserError: the recipe is not of the current plan.
        """
        job = self.plan.jobs.get(wildcards.recipe)
        if job is None:
            raise UserError(f"expected a recipe of the current plan, found {wildcards.recipe}")
        return [self._manifest(item) for item in job.needs]

    def _manifest(self, job: JobSpec) -> str:
        return str(self.store.manifest_path(job.stage, job.recipe))

    def _plan_also(self, target: str) -> None:
        """Add the jobs of a target on demand to the plan."""
        targets = {name: self.plan.jobs[recipe] for name, recipe in self.plan.targets.items()}
        job = job_on_demand(target, self.config, targets, self.overrides, self.conf)
        self.plan = build_plan(targets | {target: job})
        self.plan_path = _lay_out(self.plan, self.store, self.config)

    @one_line()
    def start(self, workflow: Any) -> None:
        """Begin this pipeline run; open a session of tracking, if it is enabled.

        On a cluster name the plan to the jobs, which read the Snakefile again with the ``--config``
        of the head, and let SIGTERM do as Ctrl-C does: Snakemake alone would wait for running jobs.
        A store that cannot be written is one line and status 1.
        """
        if workflow.local_exec:
            # The limit of submissions, which no option lifts (9.27): each job that ends would start
            # one more thread per second for it.
            workflow.scheduler.job_rate_limiter = None
        else:
            settings = workflow.config_settings
            settings.config_args = [*(settings.config_args or ()), f"{PLAN}={self.plan_path}"]
            signal.signal(signal.SIGTERM, signal.default_int_handler)
        artefacts = self.store.root
        note_start(artefacts, self.overrides)
        tracking.stop(artefacts)
        if not self.config.tracking.enabled:
            return
        tags = {_TAGS[name]: value for name, value in revision().items()}
        experiment = self.config.tracking.experiment
        apart = {"gait": f"{experiment}-gaits"}
        info = tracking.SessionInfo(experiment, os.getpid(), tags, apart)
        tags = {"plan": self.plan_path.stem, "overrides": " ".join(self.overrides)}
        title = " ".join(["pipeline", *self.overrides])[:_TITLE]  # what tells it from others
        run = {"name": title, "tags": tags, "params": to_dict(self.config)}
        self.session = tracking.start(artefacts, info, run)

    def finish(self, succeeded: bool) -> None:
        """Close the session of this pipeline run."""
        if self.session is not None:
            self.session.finish(FINISHED if succeeded else FAILED)


def cancel_rest(workflow: Any) -> None:
    """Cancel cluster jobs that Snakemake lost: submitted or asked about when it is interrupted.

    All jobs of a run have its name.
    """
    name = getattr(getattr(workflow.scheduler, "_executor", None), "run_uuid", None)
    if name:
        subprocess.run(["scancel", f"--name={name}"], check=False)


def open_pipeline(
    settings: Mapping[str, Any], conf: Path, head: bool = True, cores: int | None = None
) -> Pipeline:
    """Compose the configuration and lay out its jobs; bad input is one line and status 1.

    On a cluster each job reads the Snakefile once more. It is not the ``head``: it takes the head's
    plan as it is, also where the processor is another one, and leaves the store to the head.
    """
    gc.disable()  # a tenth of the time, and there is hardly anything to collect
    try:
        with one_line():
            return _open(settings, conf, cores) if head else _join(settings, conf)
    finally:
        gc.enable()


def _open(settings: Mapping[str, Any], conf: Path, cores: int | None) -> Pipeline:
    if sys.flags.optimize > 1:  # meanings of terms are docstrings
        raise UserError("expected Python with docstrings, found PYTHONOPTIMIZE=2: unset it")
    try:
        getpass.getuser()
    except (KeyError, OSError):  # Snakemake notes the name, which the user of a container may lack
        os.environ["USER"] = "nobody"
    overrides = parse_overrides(settings)
    config = with_renderer(checked(compose(overrides, conf)))
    plan = build_plan(all_targets(config, overrides, conf))
    notes = Path(".snakemake")  # of Snakemake, also in a dry run: without them it ends with a trace
    notes.mkdir(exist_ok=True)
    tempfile.TemporaryFile(dir=notes).close()
    store = Store(Path(ARTEFACTS))
    return Pipeline(config, overrides, plan, _lay_out(plan, store, config), store, conf, cores)


def _join(settings: Mapping[str, Any], conf: Path) -> Pipeline:
    overrides = parse_overrides({name: settings[name] for name in settings if name != PLAN})
    path = Path(str(settings.get(PLAN)))
    store = Store(Path(ARTEFACTS))
    return Pipeline(compose(overrides, conf), overrides, read_plan(path), path, store, conf)


def _lay_out(plan: Plan, store: Store, config: Config) -> Path:
    """Write a plan and make what is on disk agree with it; a read-only store stays as it is."""
    folder = store.root / "plans"
    store.check_folders({job.stage for job in plan.jobs.values()})
    try:
        path = write_plan(plan, folder)
    except OSError as error:
        if not is_read_only(error):
            raise
        return plan_path(plan, folder)
    manifests = [store.manifest_path(job.stage, job.recipe) for job in plan.jobs.values()]
    for name in drop_damaged(store, manifests).damage:
        print(f"slider: dropped {name}", file=sys.stderr)
    if config.store.remote is not None:
        _pull(plan, store, config.store.remote)
    late = date_now(store, [*manifests, *store.root.glob("current/*")])
    if late:
        text = f"dated {late} files of {store.root} now: they are from the future"
        print(f"slider: {text}, as the clock was set back", file=sys.stderr)
    for target, names in report_files(config).items():
        if target in plan.targets:
            refresh_marker(store, plan, target, [Path(name) for name in names])
    return path


def _pull(plan: Plan, store: Store, remote: str) -> None:
    """Copy the results that a plan lacks from a remote; what is not there is computed."""
    try:
        account = pull(store, plan.jobs, Remote(remote))
    except UserError as error:
        print(f"slider: {error}; what is missing is computed here", file=sys.stderr)
        return
    for line in account.damage:
        print(f"slider: {line}", file=sys.stderr)
    if "taken" in account.counts:
        print(f"slider: from {remote}: {account}", file=sys.stderr)


def parse_overrides(settings: Mapping[str, Any]) -> list[str]:
    """Overrides of ``--config hydra='...'``.

    Raises:
        UserError: another name, no text, or an open quote.
    """
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
        raise UserError(
            f"--config {OPTION}: {error} in {text!r} (Snakemake takes quotes off both ends of the "
            "value: a space before or after them keeps them)"
        ) from None
