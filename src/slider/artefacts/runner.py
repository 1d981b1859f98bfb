"""Run one job of a plan: reuse a cached result or compute, publish, then write the manifest."""

import copy
import gc
import importlib
import os
import resource
import shutil
import time
from collections.abc import Callable, Mapping
from contextlib import chdir
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from slider.artefacts.forecast import kind, size
from slider.artefacts.manifest import Manifest, Result
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import SOURCE_ROOT, code_of
from slider.artefacts.run_metadata import now, run_metadata
from slider.artefacts.store import Store, exclusive
from slider.core import files
from slider.core.errors import UserError
from slider.core.job import Job, NoTracker, StageFunction, Summary, Tracker
from slider.core.machine import check_machine, machine
from slider.tracking.journal import FAILED, FINISHED, JournalTracker, current_session


@dataclass(frozen=True)
class Runner:
    """Runs jobs against a store.

    Attributes:
        store: where inputs are and results go.
        threads: processor threads of a job.
        progress: shows one line to the person who waits.
        waiting: see :class:`Job`.
    """

    store: Store
    threads: int = 1
    progress: Callable[[str], None] = field(default=lambda message: None)
    waiting: int = 1

    def run(self, spec: JobSpec) -> str:
        """Run a job unless its result is cached; return ``reused`` or how long it took.

        Raises:
            UserError: an input is missing or damaged, the source changed since the plan, or the
                machine computes with other kernels.
        """
        with exclusive(self.store.locks, spec.recipe):
            inputs = spec.input_recipes
            objects = {
                name: [self.store.checked(job.stage, job.recipe).result.object for job in jobs]
                for name, jobs in spec.inputs.items()
            }
            key = spec.key(objects)
            manifest = self.store.indexed(key)
            if manifest is None:
                result = self._compute(spec, objects)
                manifest = Manifest(spec.stage, spec.recipe, inputs, result, objects, key)
                self.store.remember(key, manifest)
                outcome = f"{self._sidecar(spec)['wall_s']:.1f} s"
            else:
                self._note_reuse(spec, manifest)
                outcome = "reused"
            self.store.write_manifest(replace(manifest, recipe=spec.recipe, inputs=inputs))
            shutil.rmtree(self.store.work_folder(spec.stage, spec.recipe), ignore_errors=True)
        return outcome

    def _compute(self, spec: JobSpec, objects: Mapping[str, list[str]]) -> Result:
        watch = _watch()  # before the imports: they are part of what a job costs
        check_machine(spec.section)
        limit_threads(self.threads)
        keep_freed_memory()
        for compiler in ("NUMBA_CACHE_DIR", "WARP_CACHE_PATH"):
            os.environ.setdefault(compiler, str(self.store.cache_folder("compiled").absolute()))
        job = self._job(spec)
        tracker = job.tracker
        try:
            with self.store.temporary(f"{spec.stage}-{spec.recipe[:12]}") as out:
                summary = self._call(spec, objects, out.absolute(), job)
                resumed = bool(job.volatile.get("resumed", False))
                result = self.store.publish(out, files.plain(summary), resumed)
        except BaseException:
            if isinstance(tracker, JournalTracker):
                tracker.end(FAILED, {})
            raise
        facts = {**job.volatile, **watch(), "computed": True, "threads": self.threads}
        facts |= {"kind": kind(spec), "size": size(spec)}
        files.write_json(self.store.sidecar_path(spec.stage, spec.recipe), facts)
        if isinstance(tracker, JournalTracker):
            noted = {f"volatile/{name}": value for name, value in _numbers(job.volatile).items()}
            tracker.log_metrics(_numbers(summary) | noted, 0)
            self._end(tracker, result)
        return result

    def _call(
        self, spec: JobSpec, objects: Mapping[str, list[str]], out: Path, job: Job
    ) -> Summary:
        """Call the stage's function in its work folder, where no option file of a library lies."""
        inputs = {
            name: [self.store.object_folder(digest).absolute() for digest in digests]
            for name, digests in objects.items()
        }
        section = copy.deepcopy(dict(spec.section))
        section.pop("numerics", None)
        with chdir(job.work):
            function = _load(spec)
            gc.freeze()  # what was imported stays: the collector need not look at it each time
            return function(section, inputs, out, job)

    def _end(self, tracker: JournalTracker, result: Result) -> None:
        """Close the tracked run with its numbers and a path relative to the store."""
        path = self.store.object_folder(result.object).relative_to(self.store.root).as_posix()
        tags = {"object": result.object, "object.path": path, "resumed": str(result.resumed)}
        names = sorted({name.partition("/")[0] for name in result.files})
        lines = "\n".join(f"* `{path}/{name}`" for name in names)
        facts = ", ".join(f"{k} **{v:.4g}**" for k, v in _numbers(result.summary).items())
        note = f"{facts}\n\nResult, below `{self.store.root.name}/`:\n\n{lines}".lstrip()
        tracker.end(FINISHED, tags, note)

    def _job(self, spec: JobSpec) -> Job:
        work = self.store.work_folder(spec.stage, spec.recipe).absolute()
        work.mkdir(parents=True, exist_ok=True)
        code = files.digest_value([spec.code.entry, spec.code.source, spec.code.versions])
        return Job(
            work,
            self.threads,
            _open_tracker(self.store.root.absolute(), spec),
            self.progress,
            run_metadata(self.store.root),
            self.store.cache_folder(code).absolute(),
            self.waiting,
            {name: [self._sidecar(job) for job in jobs] for name, jobs in spec.inputs.items()},
        )

    def _sidecar(self, spec: JobSpec) -> dict[str, Any]:
        return self.store.facts(spec.stage, spec.recipe)

    def _note_reuse(self, spec: JobSpec, manifest: Manifest) -> None:
        """Keep the facts of the job that computed the result beside the recipe that reuses it."""
        if manifest.recipe == spec.recipe:
            return
        origin = self.store.facts(manifest.stage, manifest.recipe)
        facts = origin | {"computed": False, "reused_from": manifest.recipe, "started": now()}
        files.write_json(self.store.sidecar_path(spec.stage, spec.recipe), facts)


def _watch() -> Callable[[], dict[str, Any]]:
    """Start a clock; the function that is returned reads times [s] and the load at the start."""
    started, wall, cpu = now(), time.perf_counter(), _cpu_seconds()
    load = os.getloadavg()[0]
    return lambda: {
        "started": started,
        "ended": now(),
        "wall_s": round(time.perf_counter() - wall, 3),
        "cpu_s": round(_cpu_seconds() - cpu, 3),
        "load_1min_at_start": round(load, 2),
        "machine": machine(),
    }


def _load(spec: JobSpec) -> StageFunction:
    module, _, name = spec.code.entry.partition(":")
    function = getattr(importlib.import_module(module), name)
    # Checked after the import: what was imported is what the plan names. Without this, an edit
    # made while the pipeline runs would be stored under the recipe of the old source.
    if code_of(spec.code.entry, SOURCE_ROOT) != spec.code:
        raise UserError(
            f"the source or the packages of stage {spec.stage} changed since the pipeline was "
            "started: start it again"
        )
    return function


def limit_threads(threads: int) -> None:
    """Set the environment of OpenMP and BLAS before the stage imports them."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    os.environ.update(dict.fromkeys(names, str(threads)))
    # Spinning threads beside another job slow training down tenfold.
    os.environ.update(OMP_WAIT_POLICY="PASSIVE", GOMP_SPINCOUNT="0")


def keep_freed_memory() -> None:
    """Free one large block, so that glibc keeps what is freed from then on.

    Its thresholds follow the largest block, up to 32 MiB. Without this it returns arrays to the
    system at every step of a simulation, which takes a tenth of the processor time.
    """
    bytes(30 * 2**20)


def _open_tracker(artefacts: Path, spec: JobSpec) -> Tracker:
    session = current_session(artefacts) if spec.tracked else None
    if session is None:
        return NoTracker()
    tracker = JournalTracker(session / f"{spec.stage}-{spec.recipe[:16]}.jsonl")
    needs = dict.fromkeys(job.stage for job in spec.needs)
    tracker.begin(spec.label, {"stage": spec.stage, "recipe": spec.recipe}, list(needs))
    tracker.log_params(spec.section)
    return tracker


def _numbers(facts: Mapping[str, Any]) -> dict[str, float]:
    """Numeric entries of a summary."""
    return {name: float(value) for name, value in facts.items() if isinstance(value, int | float)}


def _cpu_seconds() -> float:
    usages = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)
