"""The stage ``gait``: one walk for one command."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.gait import FormulationConfig, SolveConfig
from slider.config.robot import Mechanism
from slider.core.job import Inputs, Job, Section, Summary
from slider.gait import REPORT
from slider.gait.costs import COSTS
from slider.gait.dense import dense_violations
from slider.gait.formulation import formulate
from slider.gait.problem import GaitProblem, build
from slider.gait.solution import (
    base_motion,
    coefficients,
    knee_trajectory,
    rolls,
    samples,
)
from slider.gait.solve import GaitSolver, Solve
from slider.robot.knee_map import prismatic_joints, with_upper_feet
from slider.robot.names import COMMAND, command_text


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Solve one gait; write its arrays as ``.npy`` and a report with residuals by name."""
    config = from_dict(SolveConfig, section["solve"])
    command = tuple(float(value) for value in section["command"])
    robot = from_dict(Mechanism, section["robot"])
    formulation = from_dict(FormulationConfig, section["formulation"])
    problem = build(formulate(robot, formulation, turning=command[2] != 0.0))
    job.progress(f"gait {command_text(command)}: built")
    solve = GaitSolver(problem, config.solver, config.step_time).solve(*command)
    job.volatile.update(solve_cpu=solve.cpu, solve_wall=solve.wall, **solve.evaluations)
    arrays = gait_arrays(problem, solve, config.kinematic_map, command[2])
    for name, array in arrays.items():
        np.save(out / f"{name}.npy", array)
    report = _report(problem, solve, command)
    (out / REPORT).write_text(json.dumps(report, indent=1) + "\n")
    return {k: report[k] for k in (*COMMAND, "status", "converged", "cost", "max_violation")}


def gait_arrays(
    problem: GaitProblem, solve: Solve, kinematic_map: str, yaw_rate: float = 0.0
) -> dict[str, np.ndarray]:
    """Arrays of a gait; see ``docs/reference/gait-library.md`` for shapes, units and frames.

    ``yaw_rate`` [rad/s] is the commanded one.
    """
    layout, variables = problem.layout, solve.variables
    trajectory = knee_trajectory(problem, variables)
    position, velocity = prismatic_joints(
        trajectory.q, trajectory.v, problem.form.robot, kinematic_map
    )
    times = np.array([variables[layout.time_index(step)] for step in range(2)])
    first, second = layout.phase * times[0], times[0] + layout.phase * times[1]
    half = layout.nodes
    stance = np.zeros((2 * half, 2))
    stance[:half, 0] = stance[half:, 1] = 1.0
    return {
        "samples": samples(position, velocity, trajectory),
        "time": np.concatenate([first, second]),
        "step_time": times,
        "coefficients": coefficients(problem, variables)[0],
        "base": base_motion(trajectory, trajectory.swing_foot[half - 1, :2], yaw_rate * times[0]),
        "contact": stance,
        "knee_positions": trajectory.q,
        "knee_velocities": trajectory.v,
        "knee_torques": trajectory.torques,
        "efforts": with_upper_feet(trajectory.efforts),
        "ground_wrench": trajectory.wrench,
        "swing_foot": trajectory.swing_foot,
        "roll": rolls(problem, variables),
    }


def _report(problem: GaitProblem, solve: Solve, command: tuple[float, ...]) -> dict[str, Any]:
    return {
        **dict(zip(COMMAND, command, strict=True)),
        "status": solve.status,
        "converged": solve.success,
        "iterations": solve.iterations,
        "attempts": [asdict(attempt) for attempt in solve.attempts],
        "cost": solve.cost,
        "cost_unit": COSTS[problem.config.cost].unit,
        "max_violation": solve.max_violation,
        "residuals": solve.residuals,
        "between_nodes": dense_violations(problem, solve.variables, command[2]),
        "coefficient_error": coefficients(problem, solve.variables)[1],
    }
