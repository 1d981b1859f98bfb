"""``slider benchmark-gaits``: where the time of a gait goes; how it grows with nodes and gaits."""

import argparse
import multiprocessing
import os
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from slider.config.gait import FormulationConfig, GaitConfig
from slider.config.robot import RobotConfig
from slider.gait.formulation import Formulation, formulate
from slider.gait.problem import build
from slider.gait.solve import GaitSolver, Solve

VELOCITIES = ((0.0, 0.0), (0.3, 0.1), (0.6, 0.0), (0.9, -0.05), (1.2, 0.0))
WORKERS = 2  # jobs at once, as with ``snakemake -j2``
_FRESH_HEADER = "fresh jobs   wall, two at once [s]   CPU of a job, median / max [s]"
_HEADER = "nodes  gaits  build  solve median / max [s CPU]  iterations  per iteration  in functions"


@dataclass(frozen=True)
class Measurement:
    """CPU times [s] of one problem and of its solves."""

    nodes: int
    build: float
    solves: list[Solve]

    @property
    def cpu(self) -> np.ndarray:
        """Of each solve [s]."""
        return np.array([solve.cpu for solve in self.solves])

    @property
    def iterations(self) -> np.ndarray:
        """Of each solve, over its attempts."""
        return np.array([sum(a.iterations for a in solve.attempts) for solve in self.solves])

    @property
    def iteration(self) -> float:
        """Mean of an iteration [s]."""
        return float(self.cpu.sum() / self.iterations.sum())

    def line(self) -> str:
        """One row of the table."""
        functions = sum(sum(solve.evaluations.values()) for solve in self.solves)
        return (
            f"{self.nodes:5d}  {len(self.cpu):5d}  {self.build:5.2f}  "
            f"{np.median(self.cpu):12.2f} / {self.cpu.max():<10.2f}  "
            f"{np.median(self.iterations):10.0f}  {1e3 * self.iteration:10.1f} ms  "
            f"{functions / self.cpu.sum():10.0%}"
        )


@dataclass(frozen=True)
class FreshJobs:
    """Gaits solved each in a process of its own, imports included [s]."""

    wall: float
    cpu: list[float]

    def line(self) -> str:
        """One row of the table."""
        return (
            f"{len(self.cpu):10d}  {self.wall:20.1f}  "
            f"{np.median(self.cpu):17.2f} / {max(self.cpu):.2f}"
        )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("overrides", nargs="*", help="such as gait.cost=torque")
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    parser.add_argument(
        "--nodes", type=int, nargs="+", default=[21, 41, 81], help="per step (default: 21 41 81)"
    )
    parser.add_argument(
        "--jobs", type=int, nargs="+", default=[1, 5, 25], help="gaits (default: 1 5 25)"
    )


def run(arguments: argparse.Namespace) -> None:
    """Print a table, one row per number of nodes."""
    from slider.artefacts.runner import limit_threads
    from slider.config.compose import compose

    limit_threads(1)  # as a job of the pipeline has
    print(f"load of the machine: {os.getloadavg()[0]:.1f}")
    print(_HEADER)
    for nodes in arguments.nodes:
        config = compose([*arguments.overrides, f"gait.nodes={nodes}"], arguments.conf)
        print(measure(config.robot, config.gait, VELOCITIES).line(), flush=True)
    config = compose(arguments.overrides, arguments.conf)
    print(_FRESH_HEADER)
    for count in arguments.jobs:
        velocities = [VELOCITIES[index % len(VELOCITIES)] for index in range(count)]
        print(measure_fresh(config.robot, config.gait, velocities).line(), flush=True)


def measure(
    robot: RobotConfig, gait: GaitConfig, velocities: Sequence[tuple[float, float]]
) -> Measurement:
    """Build a problem once and solve it cold for each velocity [m/s]."""
    start = time.process_time()
    problem = build(_formulation(robot, gait))
    solver = GaitSolver(problem, gait.solver, gait.step_time)
    built = time.process_time() - start
    return Measurement(gait.nodes, built, [solver.solve(*velocity) for velocity in velocities])


def measure_fresh(
    robot: RobotConfig, gait: GaitConfig, velocities: Sequence[tuple[float, float]]
) -> FreshJobs:
    """Solve each velocity [m/s] in a new process, ``WORKERS`` at once, as the pipeline does."""
    start = time.perf_counter()
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(WORKERS, mp_context=context, max_tasks_per_child=1) as pool:
        cpu = list(pool.map(_fresh_job, [(robot, gait, velocity) for velocity in velocities]))
    return FreshJobs(time.perf_counter() - start, cpu)


def _fresh_job(task: tuple[RobotConfig, GaitConfig, tuple[float, float]]) -> float:
    """CPU time [s] of this process from its start."""
    robot, gait, velocity = task
    measure(robot, gait, [velocity])
    return time.process_time()


def _formulation(robot: RobotConfig, gait: GaitConfig) -> Formulation:
    settings = {f.name: getattr(gait, f.name) for f in fields(FormulationConfig)}
    return formulate(robot, FormulationConfig(**settings))
