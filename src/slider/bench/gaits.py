"""``slider benchmark-gaits``: where the time of a gait goes, by the number of nodes."""

import argparse
import os
import time
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np

from slider.config.gait import FormulationConfig, GaitConfig
from slider.config.robot import RobotConfig
from slider.gait.formulation import Formulation
from slider.gait.problem import build
from slider.gait.solve import GaitSolver

VELOCITIES = ((0.0, 0.0), (0.3, 0.1), (0.6, 0.0), (0.9, -0.05), (1.2, 0.0))
_HEADER = "nodes  gaits  build  solve median / max [s CPU]  iterations  per iteration  in functions"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("overrides", nargs="*", help="such as gait.cost=torque")
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    parser.add_argument(
        "--nodes", type=int, nargs="+", default=[21, 41, 81], help="per step (default: 21 41 81)"
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
        print(measure(config.robot, config.gait, VELOCITIES), flush=True)


def measure(robot: RobotConfig, gait: GaitConfig, velocities: Sequence[tuple[float, float]]) -> str:
    """Build a problem once and solve it cold for each velocity [m/s]; a row of the table."""
    start = time.process_time()
    settings = {field.name: getattr(gait, field.name) for field in fields(FormulationConfig)}
    problem = build(Formulation(robot, FormulationConfig(**settings)))
    solver = GaitSolver(problem, gait.solver, gait.step_time)
    built = time.process_time() - start
    solves = [solver.solve(*velocity) for velocity in velocities]
    cpu = np.array([solve.cpu for solve in solves])
    iterations = [sum(one.iterations for one in solve.attempts) for solve in solves]
    functions = sum(sum(solve.evaluations.values()) for solve in solves)
    return (
        f"{gait.nodes:5d}  {len(cpu):5d}  {built:5.2f}  "
        f"{np.median(cpu):12.2f} / {cpu.max():<10.2f}  {np.median(iterations):10.0f}  "
        f"{1e3 * cpu.sum() / sum(iterations):10.1f} ms  {functions / cpu.sum():10.0%}"
    )
