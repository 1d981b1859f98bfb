"""Run one job of a plan: reuse a cached result or compute, publish, then write the manifest."""

import copy
import gc
import importlib
import json
import logging
import os
import shutil
import time
from collections.abc import Callable, Mapping
from contextlib import chdir, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

from slider.artefacts.forecast import kind, size
from slider.artefacts.manifest import Manifest, Result
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import SOURCE_ROOT, Groups, code_of
from slider.artefacts.run_metadata import forced_recipes, now, pipeline_metadata
from slider.artefacts.store import Store, exclusive
from slider.core import files
from slider.core.errors import UserError
from slider.core.job import Job, StageFunction
from slider.core.machine import check_machine, machine

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Runner:
    """Runs jobs of a plan with inputs from a store and publishes their results there.

    ``plan`` is its file; for the others see :class:`Job`.
    """

    store: Store
    plan: Path = Path()
    threads: int = 1
    progress: Callable[[str], None] = field(default=lambda message: None)
    waiting: int = 1

    def run(self, spec: JobSpec) -> str:
        """Run a job unless its result is cached; return ``reused`` or the time it took.

        Raises:
            UserError: an input is missing or damaged, the source has changed since the plan was
                written, or the machine uses other kernels.
        """
        with exclusive(self.store.locks, spec.recipe):
            inputs = spec.input_recipes
            objects = {
                name: [self.store.require(job.stage, job.recipe).result.object for job in jobs]
                for name, jobs in spec.inputs.items()
            }
            key, outcome = spec.key(objects), "reused"
            forced = spec.recipe in forced_recipes(self.plan)
            manifest = None if forced else self.store.find(key)
            if manifest is None:
                began = time.perf_counter()
                result = self._compute(spec, objects)
                manifest = Manifest(spec.stage, spec.recipe, inputs, result, objects, key)
                self.store.put_index(key, manifest)
                outcome = f"{time.perf_counter() - began:.1f} s"
            elif manifest.recipe != spec.recipe:  # with the metadata of the job that computed it
                metadata = self.store.metadata(manifest.stage, manifest.recipe) | {
                    "computed": False,
                    "reused_from": manifest.recipe,
                    "started": now(),
                }
                files.write_json(self.store.metadata_path(spec.stage, spec.recipe), metadata)
            self.store.write_manifest(replace(manifest, recipe=spec.recipe, inputs=inputs))
            shutil.rmtree(self.store.work_folder(spec.stage, spec.recipe), ignore_errors=True)
        return outcome

    def _compute(self, spec: JobSpec, objects: Groups) -> Result:
        """Compute and publish a result; write its run metadata next to the manifest."""
        started, wall, cpu = now(), time.perf_counter(), _cpu_seconds()  # includes the imports
        check_machine(spec.section)
        limit_threads(self.threads)
        # glibc adapts its mmap threshold to the largest freed block, up to 32 MiB. Without this it
        # returns arrays to the system at every simulation step, which costs a tenth of the time.
        bytes(30 * 2**20)
        for compiler in ("NUMBA_CACHE_DIR", "WARP_CACHE_PATH"):
            os.environ.setdefault(compiler, str(self.store.cache_folder("compiled").absolute()))
        job, name = self._job(spec), f"{spec.stage}-{spec.recipe[:12]}"
        for left in self.store.tmp.glob(f"{name}-*"):  # left by a killed job
            shutil.rmtree(left, ignore_errors=True)
        with self.store.temporary(name) as out:
            inputs = {
                name: [self.store.object_folder(digest).absolute() for digest in digests]
                for name, digests in objects.items()
            }
            section = copy.deepcopy(dict(spec.section))
            section.pop("numerics", None)
            folder = out.absolute()
            with chdir(job.work):  # a folder without option files of libraries
                function = _load(spec)
                gc.freeze()  # imported objects stay: the collector need not visit them
                summary = function(section, inputs, folder, job)
            result = self.store.publish(out, summary)
        metadata = job.metadata | {
            "started": started,
            "ended": now(),
            "wall_s": round(time.perf_counter() - wall, 3),
            "cpu_s": round(_cpu_seconds() - cpu, 3),
            "machine": machine(),
            "computed": True,
            "threads": self.threads,
            "kind": kind(spec),
            "size": size(spec),
        }
        files.write_json(self.store.metadata_path(spec.stage, spec.recipe), metadata)
        return result

    def _job(self, spec: JobSpec) -> Job:
        work = self.store.work_folder(spec.stage, spec.recipe).absolute()
        work.mkdir(parents=True, exist_ok=True)
        code = files.digest_value([spec.code.entry, spec.code.source, spec.code.versions])
        return Job(
            work,
            self.threads,
            MetricsFile(self.store.metrics_path(spec.stage, spec.recipe).absolute()),
            self.progress,
            pipeline_metadata(self.plan),
            self.store.cache_folder(code).absolute(),
            self.waiting,
            {
                name: [self.store.metadata(job.stage, job.recipe) for job in jobs]
                for name, jobs in spec.inputs.items()
            },
        )


def _load(spec: JobSpec) -> StageFunction:
    module, _, name = spec.code.entry.partition(":")
    function = getattr(importlib.import_module(module), name)
    # Checked after the import, so that the imported source is that of the plan. Otherwise, results
    # of an edit made while the pipeline runs would be stored under the recipe of the old source.
    if code_of(spec.code.entry, SOURCE_ROOT) != spec.code:
        raise UserError(
            f"the source or the packages of stage {spec.stage} changed since the pipeline was "
            "started: start it again"
        )
    return function


class MetricsFile:
    """Appends metrics to a file. Never raises: after a failure it logs a warning and stops."""

    def __init__(self, path: Path) -> None:
        self._path, self._works = path, True
        with suppress(OSError):
            path.unlink(missing_ok=True)

    def __call__(self, metrics: Mapping[str, float], step: int) -> None:
        """Append the metrics of a step."""
        if not self._works:
            return
        try:
            values = {name: float(value) for name, value in metrics.items()}
            event = {"time": time.time_ns() // 1_000_000, "step": int(step), "values": values}
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(event) + "\n")
        except Exception as error:
            self._works = False
            _log.warning("no further metrics are written, the stage goes on: %s", error)


def limit_threads(threads: int) -> None:
    """Set the environment of OpenMP and BLAS before the stage imports them."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    os.environ.update(dict.fromkeys(names, str(threads)))
    # Threads that spin while another job runs slow training down tenfold.
    os.environ.update(OMP_WAIT_POLICY="PASSIVE", GOMP_SPINCOUNT="0")


def _cpu_seconds() -> float:
    return sum(os.times()[:4])  # includes child processes
