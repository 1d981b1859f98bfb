"""``slider benchmark-growth``: how times grow with gaits, nodes, robots, threads and objects."""

import argparse
import multiprocessing
import os
import resource
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from slider.core import files
from slider.core.errors import UserError
from slider.library.choose import add_library_arguments, library_path
from slider.reports.rows import write

SNAKEFILE = Path("Snakefile")
_NODES = (11, 21, 41, 81)
_VY_STEPS = (0.05, 0.005, 0.00125)  # of the paper's grid [m/s]: 125, 1025 and 4025 gaits
_PLAN = "gait.grid.vy.step={} gait.grid.extra=[] tracking.enabled=false"
_COUNTS = (100, 1000, 10_000)
_ENVS = (256, 1024, 4096)
_SIZES = (100, 1000, 4000)
_CONTROLLER, _SPEED, _SECONDS = "mpc_wbc_tuned", 0.6, 2.0
_CORES = (1, 2, 4, 8, 16, 64)
_BYTES = 4096  # of a small object

Curve = Iterator[tuple[float, str, float]]
"""How much of what grows there is; a quantity with its unit, and its value."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    parser.add_argument("--curves", nargs="+", choices=CURVES, default=list(CURVES))
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2, 4], help="default: 1 2 4")
    parser.add_argument("--out", type=Path, help="also write the points as CSV")
    add_library_arguments(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print a line per point as it is measured."""
    from slider.core.machine import machine

    if min(arguments.threads) < 1:
        raise UserError(f"--threads: expected at least 1, found {min(arguments.threads)}")
    if not SNAKEFILE.is_file():
        raise UserError(f"expected {SNAKEFILE} in this folder, found none")
    print(f"{machine()}; load {os.getloadavg()[0]:.1f} before the start", flush=True)
    rows = []
    for curve in arguments.curves:
        for count, name, value in CURVES[curve](arguments):
            rows.append({"curve": curve, "count": count, "name": name, "value": value})
            print(f"{count:8g} {curve:<14}{name:<52}{value:>8.3g}", flush=True)
    print(f"load {os.getloadavg()[0]:.1f} at the end")
    if arguments.out is not None:
        write(rows, arguments.out)


def _nodes(arguments: argparse.Namespace) -> Curve:
    """Five gaits at each number of nodes per step."""
    from slider.bench.gaits import VELOCITIES, measure
    from slider.config.compose import compose

    for nodes in _NODES:
        config = compose([f"gait.nodes={nodes}"], arguments.conf)
        found = _apart(1, measure, config.robot, config.gait, VELOCITIES)
        yield nodes, "build [s]", found.build
        yield nodes, "solve, median [s]", float(np.median(found.cpu))
        yield nodes, "iteration [ms]", 1e3 * found.iteration


def _environments(arguments: argparse.Namespace) -> Curve:
    """Physics alone, environment and whole training at each number of robots and threads."""
    from slider.bench.throughput import measure
    from slider.config.compose import compose
    from slider.core.numerics import precision

    config, library = compose([], arguments.conf), library_path(arguments)
    how = [precision("auto")], 1.0, 3
    for threads in arguments.threads:
        for envs in _ENVS:
            found = _apart(threads, measure, config, library, threads, envs, *how)[0]
            plural = "thread" if threads == 1 else "threads"
            for part in ("bare", "environment", "loop"):
                name = f"{part}, {threads} {plural} [1000 steps/s]"
                yield envs, name, getattr(found, part).wall / 1e3


def _robots(arguments: argparse.Namespace) -> Curve:
    """A baseline, whole and its physics alone, at each number of robots."""
    from slider.bench.control import measure
    from slider.config.compose import compose

    config = compose([], arguments.conf)
    _apart(1, measure, config, _CONTROLLER, None, 1, _SPEED, 0.1)  # compiles the tick
    for robots in _SIZES:
        cost = _apart(1, measure, config, _CONTROLLER, None, robots, _SPEED, _SECONDS)
        yield robots, "controller and physics [µs per robot and tick]", cost.whole
        yield robots, "physics alone [µs per robot and tick]", cost.physics


def _objects(_: argparse.Namespace) -> Curve:
    """A store of small objects, listed, verified and cleaned."""
    from slider.artefacts.maintenance import collect, summarise, verify
    from slider.artefacts.plan import Plan, write_plan
    from slider.artefacts.store import Store

    for count in _COUNTS:
        with tempfile.TemporaryDirectory() as folder:
            store = Store(Path(folder) / "artefacts")
            yield count, "publish [s]", _seconds(partial(_fill, store, count))
            write_plan(Plan({}, {}), store.root / "plans")
            yield count, "ls [s]", _seconds(partial(summarise, store))
            yield count, "verify [s]", _seconds(partial(verify, store))
            look = partial(collect, store, keep=1, dry_run=True)
            yield count, "gc --dry-run [s]", _seconds(look)
            yield count, "gc of all [s]", _seconds(partial(collect, store, keep=1))


def _fill(store: Any, count: int) -> None:
    """Publish objects of one small file each, with a manifest."""
    from slider.artefacts.manifest import Manifest

    for number in range(count):
        with store.temporary("growth") as folder:
            (folder / "result.bin").write_bytes(number.to_bytes(8) * (_BYTES // 8))
            result = store.publish(folder, {})
        recipe = files.digest_text(str(number))
        store.write_manifest(Manifest("growth", recipe, {}, result, {}))


def _gaits(arguments: argparse.Namespace) -> Curve:
    """What a dry run takes, by the number of gaits; what the default takes, by that of cores."""
    for step in _VY_STEPS:
        seconds, plan = _dry_run(_PLAN.format(step))
        gaits = sum(job.stage == "gait" for job in plan.jobs.values())
        yield gaits, "dry run [s]", seconds


def _cores(arguments: argparse.Namespace) -> Curve:
    """Table 1 by a schedule of the times that ship: all, and the longest way alone."""
    from slider.artefacts.forecast.schedule import Forecast

    plan = _dry_run("tracking.enabled=false")[1]
    work = sum(one.seconds for one in _works(plan, 1).values())
    for cores in _CORES:
        works = _works(plan, cores)
        yield cores, "Table 1 [min]", Forecast(works, cores).left(0.0) / 60
        bound = max(work / cores, max(one.priority for one in works.values()))
        yield cores, "least: work / cores, or the longest way [min]", bound / 60


def _works(plan: Any, cores: int) -> Mapping[str, Any]:
    """The jobs of Table 1 with their times; more urgent is what has the longer way to the end."""
    from slider.artefacts.forecast.schedule import Work
    from slider.artefacts.forecast.times import Times, shipped
    from slider.artefacts.plan import build_plan
    from slider.core.threads import threads

    jobs = build_plan({"table1": plan.jobs[plan.targets["table1"]]}).jobs
    times, way = Times([], shipped()), dict.fromkeys(jobs, 0.0)
    works = {}
    for recipe, job in reversed(list(jobs.items())):  # inputs come first
        trained = job.stage in ("standing", "walking")
        seconds = times.seconds(job, threads(cores) if trained else 1)
        inputs = [item.recipe for items in job.inputs.values() for item in items]
        way[recipe] += seconds
        uses = times.seconds(job) / seconds
        works[recipe] = Work(job.stage, seconds, inputs, way[recipe], uses=uses)
        for item in inputs:
            way[item] = max(way[item], way[recipe])
    return works


def _dry_run(hydra: str) -> tuple[float, Any]:
    """Processor time of Snakemake's dry run in an empty folder [s], and its plan."""
    from slider.artefacts.current import current_plan
    from slider.artefacts.store import Store

    command = [sys.executable, "-m", "snakemake", "-n", "reports/table1.csv"]
    command += ["-s", str(SNAKEFILE.resolve()), "--config", f"hydra={hydra}", "--directory"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([*command, folder], capture_output=True, text=True, check=False)
        if done.returncode:
            raise UserError(f"{shlex.join(command)}: {done.stderr.strip()[-300:]}")
        plan = current_plan(Store(Path(folder) / "artefacts"))
    assert plan is not None
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, plan


def _apart(threads: int, function: Callable[..., Any], *arguments: Any) -> Any:
    """What a function returns in a process of its own, in which so many threads are allowed."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, context, initializer=_limit, initargs=(threads,)) as pool:
        return pool.submit(function, *arguments).result()


def _limit(threads: int) -> None:
    from slider.artefacts.runner import keep_freed_memory, limit_threads

    limit_threads(threads)
    keep_freed_memory()


def _seconds(work: Callable[[], object]) -> float:
    """Wall time [s]: the disk counts."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


CURVES: dict[str, Callable[[argparse.Namespace], Curve]] = {
    "nodes": _nodes,
    "environments": _environments,
    "robots": _robots,
    "objects": _objects,
    "gaits": _gaits,
    "cores": _cores,
}
