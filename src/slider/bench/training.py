"""``slider benchmark-training``: control steps per second of physics, environment and training."""

import argparse
import math
import os
import resource
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from slider.core.errors import UserError
from slider.library.choose import add_library_arguments, library_path

if TYPE_CHECKING:
    from slider.bench.throughput import Rate, Throughput
    from slider.config.schema import Config

PRECISIONS = ("float32", "bfloat16")
_HEADER = (
    "                      control steps per second, thousands            of bare rollout\n"
    "  envs  precision        bare rollout      environment    whole loop      environment    loop"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("overrides", nargs="*", help="such as train.walking.ppo.epochs=5")
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    parser.add_argument(
        "--envs",
        type=int,
        nargs="+",
        default=[256, 1024, 4096, 8192],
        help="environments (default: 256 1024 4096 8192)",
    )
    parser.add_argument(
        "--precision",
        nargs="+",
        choices=PRECISIONS,
        help="of the update (default: those that the processor has)",
    )
    parser.add_argument("--seconds", type=float, default=2.0, help="per measurement (default: 2)")
    parser.add_argument("--rounds", type=int, default=3, help="median of so many (default: 3)")
    parser.add_argument("--threads", type=int, help="default: resources.threads, else 1")
    parser.add_argument("--device", help="also MuJoCo Warp alone there, such as cuda:0 or cpu")
    add_library_arguments(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print a row per number of environments and precision, then where the time goes."""
    _check(arguments)
    from slider.artefacts.runner import limit_threads
    from slider.config.compose import compose
    from slider.core.machine import machine
    from slider.env.terms import checked

    config = checked(compose(arguments.overrides, arguments.conf))
    library = library_path(arguments)
    threads = arguments.threads or config.resources.threads or 1
    limit_threads(threads)  # before torch, as for a job of the pipeline
    print(f"{machine()}; {threads} threads, load {os.getloadavg()[0]:.1f} before the start")
    print(_HEADER, flush=True)
    found = []
    for num_envs in arguments.envs:
        for row in _measure(arguments, config, library, threads, num_envs):
            found.append(row)
            print(line(row), flush=True)
    if arguments.device:
        print(f"\nMuJoCo Warp alone on {arguments.device}, thousands of control steps per second")
        for num_envs, rate in {row.num_envs: row.warp for row in found}.items():
            print(f"{num_envs:6d}  {_rate(rate)}")
    print("\nwhere the processor time of the training goes")
    for row in found:
        print(f"{row.num_envs:6d}  {row.precision:<9}  {_parts(row.parts)}")
    print(f"\nlargest memory {_peak():.2f} GiB, load {os.getloadavg()[0]:.1f} at the end")


def _check(arguments: argparse.Namespace) -> None:
    limits = {
        "--envs": min(arguments.envs),
        "--rounds": arguments.rounds,
        "--threads": 1 if arguments.threads is None else arguments.threads,
    }
    for name, value in limits.items():
        if value < 1:
            raise UserError(f"{name}: expected at least 1, found {value}")
    if not 0 < arguments.seconds < math.inf:
        raise UserError(f"--seconds: expected a positive number, found {arguments.seconds}")


def _measure(
    arguments: argparse.Namespace, config: "Config", path: Path, threads: int, num_envs: int
) -> list["Throughput"]:
    from slider.bench.throughput import Bench
    from slider.core.numerics import kernels, precision
    from slider.env.task import task_of

    train = replace(config.train.walking, robots=num_envs)
    task = task_of(config.robot, config.env, train, path)
    fastest = PRECISIONS.index(precision("auto", kernels()))
    precisions = arguments.precision or PRECISIONS[: fastest + 1]
    with tempfile.TemporaryDirectory() as work:
        bench = Bench(task, threads, Path(work), arguments.device)
        return bench.measure(list(precisions), arguments.seconds, arguments.rounds)


def line(row: "Throughput") -> str:
    """One row of the table: steps per second, in brackets per second of processor time."""
    return (
        f"{row.num_envs:6d}  {row.precision:<9}  {_rate(row.bare)}  {_rate(row.environment)}  "
        f"{_rate(row.loop)}  {row.environment_share:9.0%}  {row.loop_share:9.0%}"
    )


def _rate(rate: "Rate") -> str:
    return f"{rate.wall / 1e3:7.1f} ({rate.cpu / 1e3:5.1f})"


def _parts(parts: dict[str, float]) -> str:
    ordered = sorted(parts.items(), key=lambda item: -item[1])
    return ", ".join(f"{name} {100 * share:.1f} %" for name, share in ordered)


def _peak() -> float:
    """Largest resident memory of this process so far [GiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
