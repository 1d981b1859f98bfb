"""The stage ``gait``: one walk for one commanded velocity."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.gait import FormulationConfig, SolveConfig
from slider.config.robot import Mechanism
from slider.core.job import Inputs, Job, Section, Summary
from slider.gait.costs import COSTS
from slider.gait.dense import dense_violations
from slider.gait.formulation import Formulation, formulate
from slider.gait.problem import GaitProblem, build
from slider.gait.solution import (
    base_motion,
    coefficients,
    knee_trajectory,
    prismatic_joints,
    rolls,
    samples,
)
from slider.gait.solve import GaitSolver, Solve

REPORT = "report.json"


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Solve one gait; write its arrays as ``.npy`` and a report with residuals by name."""
    form = formulation(section)
    config = from_dict(SolveConfig, section["solve"])
    vx, vy = (float(v) for v in section["velocity"])
    problem = build(form)
    job.progress(f"gait ({vx:g}, {vy:g}) m/s: built")
    solve = GaitSolver(problem, config.solver, config.step_time).solve(vx, vy)
    job.volatile.update(solve_cpu=solve.cpu, solve_wall=solve.wall, **solve.evaluations)
    arrays = gait_arrays(problem, solve, form, config.kinematic_map)
    for name, array in arrays.items():
        np.save(out / f"{name}.npy", array)
    report = _report(problem, solve, vx, vy)
    (out / REPORT).write_text(json.dumps(report, indent=1) + "\n")
    return {k: report[k] for k in ("vx", "vy", "status", "converged", "cost", "max_violation")}


def formulation(section: Section) -> Formulation:
    """The formulation of a section with ``robot`` and ``formulation``."""
    robot = from_dict(Mechanism, section["robot"])
    return formulate(robot, from_dict(FormulationConfig, section["formulation"]))


def gait_arrays(
    problem: GaitProblem, solve: Solve, form: Formulation, kinematic_map: str
) -> dict[str, np.ndarray]:
    """Arrays of a gait; see ``docs/reference/gait-library.md`` for shapes, units and frames."""
    layout, variables = problem.layout, solve.variables
    trajectory = knee_trajectory(problem, variables)
    model = form.tree.model
    position, velocity, effort = prismatic_joints(
        trajectory, model.thigh, model.shank, form.robot.geometry.leg_length, kinematic_map
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
        "base": base_motion(trajectory, trajectory.swing_foot[half - 1, :2]),
        "contact": stance,
        "knee_positions": trajectory.q,
        "knee_velocities": trajectory.v,
        "knee_torques": trajectory.torques,
        "efforts": effort,
        "ground_wrench": trajectory.wrench,
        "swing_foot": trajectory.swing_foot,
        "roll": rolls(problem, variables),
    }


def _report(problem: GaitProblem, solve: Solve, vx: float, vy: float) -> dict[str, Any]:
    return {
        "vx": vx,
        "vy": vy,
        "status": solve.status,
        "converged": solve.success,
        "iterations": solve.iterations,
        "attempts": [asdict(attempt) for attempt in solve.attempts],
        "cost": solve.cost,
        "cost_unit": COSTS[problem.config.cost].unit,
        "max_violation": solve.max_violation,
        "residuals": solve.residuals,
        "between_nodes": dense_violations(problem, solve.variables),
        "coefficient_error": coefficients(problem, solve.variables)[1],
    }
