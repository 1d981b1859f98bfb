"""Interface of the Snakefile: the current plan, the files of its jobs, tracking."""

import errno
import getpass
import os
import shlex
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import psutil

from pipeline import private
from pipeline.stages.page import with_renderer
from pipeline.targets import all_targets, job_on_demand, refresh_marker, report_files
from slider.artefacts.maintenance import drop_damaged
from slider.artefacts.plan import JobSpec, Plan, build_plan, plan_path, plan_paths, write_plan
from slider.artefacts.remote import Remote
from slider.artefacts.run_metadata import note_start, revision, was_started
from slider.artefacts.store import ARTEFACTS, Store
from slider.artefacts.transfer import pull
from slider.composition.compose import compose
from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.core import environment
from slider.core.errors import UserError, not_written, require
from slider.core.machine import training_threads
from slider.env.terms import checked
from slider.tracking import Tracking

OPTION = "hydra"  # of --config
_TITLE = 80  # characters
_TAGS = {"commit": "mlflow.source.git.commit", "dirty": "git.dirty"}  # MLflow shows the first


@contextmanager
def one_line() -> Iterator[None]:
    """On bad input or a file error, end the process with a one-line message and status 1."""
    try:
        yield
    except UserError as error:
        _print(error)
    except OSError as error:
        place = f"{error.filename2 or error.filename}: {error.strerror}"
        _print(not_written(error, Path(ARTEFACTS)) or place)
    else:
        return
    raise SystemExit(1) from None


def _print(line: object) -> None:
    print(f"slider: {line}", file=sys.stderr, flush=True)


@dataclass
class Pipeline:
    """The jobs of one configuration, as files below the working directory.

    ``cores`` is the number of cores shared by all jobs. A ``dry_run`` removes no result.
    ``earlier`` are the files of plans from before.
    """

    config: Config
    overrides: Sequence[str]
    plan: Plan
    plan_path: Path
    store: Store
    conf: Path
    cores: int = 1
    dry_run: bool = False
    earlier: Sequence[Path] = ()
    tracking: Tracking | None = None

    @property
    def reports(self) -> dict[str, tuple[str, ...]]:
        """Report files by target."""
        return report_files(self.config)

    @property
    def run(self) -> str:
        """Shell command that runs a job; its recipe must be appended."""
        return f"{self.slider} run --plan {self.plan_path}"

    @property
    def slider(self) -> str:
        """Shell command ``slider`` in the environment of a job.

        glibc reads variables when a process starts: they could hide instructions of the
        processor, or replace functions of the mathematical library.
        """
        words = (sys.executable, "-I", "-X", "utf8", environment.__file__)
        folders = environment.library_path(os.environ.get("LD_LIBRARY_PATH", ""))
        loader = f"GLIBC_TUNABLES= LD_PRELOAD= LD_LIBRARY_PATH={shlex.quote(folders)}"
        return f"{loader} {shlex.join(words)}"

    def threads(self, slots: int) -> int:
        """Threads of a training that holds ``slots`` of Snakemake's cores.

        By default its physics has more threads, which use cores that other jobs leave idle.
        """
        if self.config.resources.threads is not None:
            return slots
        return max(slots, training_threads(self.cores))

    def gpu(self, wildcards: Any) -> int:
        """1 if the job of a recipe needs a GPU."""
        return int(self.plan.jobs[wildcards.recipe].section["train"]["device"] == "cuda")

    def manifest(self, target: str) -> Callable[[Any], str]:
        """Input function: the manifest of a target, whose jobs are added to the plan if missing.

        A target whose jobs cannot be created ends the process with one line and status 1.
        """

        @one_line()
        def find(wildcards: Any) -> str:
            if target not in self.plan.targets:
                targets = {name: self.plan.jobs[r] for name, r in self.plan.targets.items()}
                job = job_on_demand(target, self.config, targets, self.overrides, self.conf)
                self.plan, smaller = build_plan(targets | {target: job}), self.plan_path
                self.plan_path = _lay_out(self.plan, self.store, self.config, self.dry_run)
                new = smaller.is_file() and smaller not in (*self.earlier, self.plan_path)
                if new and not was_started(smaller):  # one plan per call
                    smaller.unlink(missing_ok=True)
            return self._manifest(self.plan.jobs[self.plan.targets[target]])

        return find

    def inputs(self, wildcards: Any) -> list[str]:
        """Manifests that the job of a recipe needs.

        Raises:
            UserError: the recipe is not in the current plan.
        """
        recipe = wildcards.recipe
        require(recipe in self.plan.jobs, "recipe", "one of the current plan", recipe)
        return [self._manifest(item) for item in self.plan.jobs[recipe].needs]

    def _manifest(self, job: JobSpec) -> str:
        return str(self.store.manifest_path(job.stage, job.recipe))

    @one_line()
    def start(self, workflow: Any) -> None:
        """Start this pipeline run and, if enabled, its tracking.

        SIGTERM acts like Ctrl-C: Snakemake by default would wait for running jobs.
        """
        signal.signal(signal.SIGTERM, _end_jobs)
        private.submit_at_once(workflow)
        if not self.plan_path.is_file():  # another call may have removed its own
            write_plan(self.plan, self.plan_path.parent)
        note_start(self.plan_path, self.overrides, private.forced_recipes(workflow))
        if self.config.tracking.enabled:
            overrides = " ".join(self.overrides)
            self.tracking = Tracking(
                self.store,
                self.plan,
                self.config.tracking.experiment,
                name=f"pipeline {overrides}".strip()[:_TITLE],
                params=to_dict(self.config),
                tags={"plan": self.plan_path.stem, "overrides": overrides},
                common={_TAGS[name]: value for name, value in revision().items()},
            )

    def finish(self, succeeded: bool) -> None:
        """Wait until this pipeline run is written to MLflow."""
        if self.tracking is not None:
            self.tracking.finish(succeeded)
            if self.tracking.error is not None:
                _print(f"MLflow misses part of this run: {self.tracking.error}")


def end_as_by_ctrl_c() -> None:
    """Let SIGTERM and SIGHUP raise ``KeyboardInterrupt``, so that Snakemake removes its lock.

    A second Ctrl-C is ignored: during Snakemake's clean-up it would end in a traceback.
    """
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_DFL:  # not under nohup
            signal.signal(number, signal.default_int_handler)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt_once)


def _end_jobs(number: int, frame: FrameType | None) -> None:
    """Forward the signal to running jobs, as a terminal does with Ctrl-C."""
    for child in psutil.Process().children(recursive=True):
        with suppress(psutil.Error):
            child.send_signal(number)
    raise KeyboardInterrupt


def _interrupt_once(number: int, frame: FrameType | None) -> None:
    signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt


@one_line()
def open_pipeline(
    settings: Mapping[str, Any], conf: Path, cores: int = 1, dry_run: bool = False
) -> Pipeline:
    """Compose the configuration and create its jobs; bad input ends with one line and status 1.

    A ``dry_run`` removes no result.
    """
    store = Store(Path(ARTEFACTS))
    try:
        getpass.getuser()
    except (KeyError, OSError):  # Snakemake needs a user name, which a container may lack
        os.environ["USER"] = "nobody"
    overrides = parse_overrides(settings)
    config = with_renderer(checked(compose(overrides, conf)))
    plan = build_plan(all_targets(config, overrides, conf))
    earlier = plan_paths(store.root / "plans")
    path = _lay_out(plan, store, config, dry_run)
    return Pipeline(config, overrides, plan, path, store, conf, cores, dry_run, earlier)


def _lay_out(plan: Plan, store: Store, config: Config, dry_run: bool) -> Path:
    """Write a plan, drop damaged results, pull missing ones; a read-only store is left as it is."""
    folder = store.root / "plans"
    try:
        path = write_plan(plan, folder)
    except OSError as error:
        if not isinstance(error, PermissionError) and error.errno != errno.EROFS:
            raise
        return plan_path(plan, folder)
    manifests = [store.manifest_path(job.stage, job.recipe) for job in plan.jobs.values()]
    for line in drop_damaged(store, manifests, dry_run):
        _print(line)
    if remote := config.store.remote:
        try:
            report = pull(store, plan.jobs, Remote(remote))
        except UserError as error:
            _print(f"{error}; what is missing is computed here")
        else:
            for line in report.damage:
                _print(line)
            if "fetched" in report.counts:
                _print(f"from {remote}: {report}")
    for target, names in report_files(config).items():
        if target in plan.targets:
            refresh_marker(store, plan, target, [Path(name) for name in names])
    return path


def parse_overrides(settings: Mapping[str, Any]) -> list[str]:
    """Overrides of ``--config hydra='...'``.

    Raises:
        UserError: another option, a value that is not text, or an unclosed quote.
    """
    expected = f"{OPTION}='key=value ...'"
    for name in settings:
        require(name == OPTION, "--config", expected, name)
    text = settings.get(OPTION) or ""  # none given, or nothing between the quotes
    require(isinstance(text, str), "--config", expected, repr(text))
    try:
        return shlex.split(text)
    except ValueError as error:
        hint = "Snakemake takes quotes off both ends: a space before or after them keeps them"
        raise UserError(f"--config {OPTION}: {error} in {text!r} ({hint})") from None
