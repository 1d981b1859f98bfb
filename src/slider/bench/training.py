"""``slider benchmark-training``: control steps per second of physics, environment and training."""

import argparse
import math
import os
import resource
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
    "                      control steps per second, thousands            of bare physics\n"
    "  envs  precision        bare physics      environment    whole loop      environment    loop"
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
    parser.add_argument("--device", choices=("cpu", "cuda"), help="with MuJoCo Warp on it")
    add_library_arguments(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print a row per number of environments and precision, then where the time goes."""
    _check(arguments)
    from slider.artefacts.runner import limit_threads
    from slider.config.compose import compose
    from slider.core.machine import machine
    from slider.env.terms import checked

    overrides = [*arguments.overrides, *_on(arguments.device)]
    config = _resolved(checked(compose(overrides, arguments.conf)))
    library = library_path(arguments)
    threads = arguments.threads or config.resources.threads or 1
    limit_threads(threads)  # before torch, as for a job of the pipeline
    from slider.bench.throughput import measure

    print(f"{machine()}; {threads} threads, load {os.getloadavg()[0]:.1f} before the start")
    print(_HEADER, flush=True)
    on_processor = config.train.walking.device == "cpu"
    precisions, found = arguments.precision or _precisions(on_processor), []
    for num_envs in arguments.envs:
        how = precisions, arguments.seconds, arguments.rounds
        for row in measure(config, library, threads, num_envs, *how):
            found.append(row)
            print(line(row), flush=True)
    if on_processor:  # on a GPU the host's time is that of launches
        print("\nwhere the processor time of the training goes")
        for row in found:
            print(f"{row.num_envs:6d}  {row.precision:<9}  {_parts(row)}")
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


def _on(device: str | None) -> list[str]:
    """What trains with MuJoCo Warp there."""
    key = "train.walking"
    return [f"{key}.simulator=mujoco_warp", f"{key}.device={device}"] if device else []


def _resolved(config: "Config") -> "Config":
    """With the device that is there in the place of ``auto``."""
    from slider.core.numerics import device

    walking = replace(config.train.walking, device=device(config.train.walking.device))
    return replace(config, train=replace(config.train, walking=walking))


def _precisions(on_processor: bool) -> tuple[str, ...]:
    """Those that the processor has; on a GPU what ``auto`` means there."""
    from slider.core.numerics import precision

    if not on_processor:
        return PRECISIONS[:1]
    return PRECISIONS[: PRECISIONS.index(precision("auto")) + 1]


def line(row: "Throughput") -> str:
    """One row of the table: steps per second, in brackets per second of processor time."""
    return (
        f"{row.num_envs:6d}  {row.precision:<9}  {_rate(row.bare)}  {_rate(row.environment)}  "
        f"{_rate(row.loop)}  {row.environment_share:9.0%}  {row.loop_share:9.0%}"
    )


def _rate(rate: "Rate") -> str:
    return f"{rate.wall / 1e3:7.1f} ({rate.cpu / 1e3:5.1f})"


def _parts(row: "Throughput") -> str:
    """The parts, longest first; beside the update what its matrix products take alone."""
    notes = {"update": f" (its matrix products alone {100 * row.products_share:.1f} %)"}
    ordered = sorted(row.parts.items(), key=lambda item: -item[1])
    return ", ".join(f"{name} {100 * share:.1f} %{notes.get(name, '')}" for name, share in ordered)


def _peak() -> float:
    """Largest resident memory of this process so far [GiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
