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
from slider.gait import REPORT
from slider.gait.costs import COSTS
from slider.gait.decoupling import NAME as DECOUPLING
from slider.gait.decoupling import decoupling, shortfall
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
from slider.robot.knee_map import prismatic_joints, reflected, with_upper_feet
from slider.robot.names import ACTUATED


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Solve one gait; write its arrays as ``.npy`` and a report with residuals by name."""
    solver, velocity = prepare(section, job)
    solve = solver.solve(*velocity)
    arrays, summary = write_report(section, solver.problem, solve, out, job)
    for name, array in arrays.items():
        np.save(out / f"{name}.npy", array)
    return summary


def prepare(section: Section, job: Job) -> tuple[GaitSolver, tuple[float, float]]:
    """Solver of a section, and its commanded velocity [m/s]."""
    config = from_dict(SolveConfig, section["solve"])
    vx, vy = _velocity(section)
    robot = from_dict(Mechanism, section["robot"])
    problem = build(formulate(robot, from_dict(FormulationConfig, section["formulation"])))
    job.progress(f"gait ({vx:g}, {vy:g}) m/s: built")
    return GaitSolver(problem, config.solver, config.step_time), (vx, vy)


def write_report(
    section: Section, problem: GaitProblem, solve: Solve, out: Path, job: Job
) -> tuple[dict[str, np.ndarray], Summary]:
    """Write the report of a solve and note its times; arrays of the gait, and the summary."""
    velocity = _velocity(section)
    job.volatile.update(solve_cpu=solve.cpu, solve_wall=solve.wall, **solve.evaluations)
    arrays = gait_arrays(problem, solve, section["solve"]["kinematic_map"])
    missed = shortfall(arrays[DECOUPLING], section["solve"]["decoupling_min"])
    report = _report(problem, solve, *velocity, missed)
    (out / REPORT).write_text(json.dumps(report, indent=1) + "\n")
    names = ("vx", "vy", "status", "converged", "cost", "max_violation")
    return arrays, {name: report[name] for name in names}


def _velocity(section: Section) -> tuple[float, float]:
    vx, vy = (float(v) for v in section["velocity"])
    return vx, vy


def gait_arrays(problem: GaitProblem, solve: Solve, kinematic_map: str) -> dict[str, np.ndarray]:
    """Arrays of a gait; see ``docs/reference/gait-library.md`` for shapes, units and frames."""
    layout, variables = problem.layout, solve.variables
    trajectory = knee_trajectory(problem, variables)
    robot, half = problem.form.robot, layout.nodes
    position, velocity = prismatic_joints(trajectory.q, trajectory.v, robot, kinematic_map)
    times = np.array([variables[layout.time_index(step)] for step in range(2)])
    first, second = layout.phase * times[0], times[0] + layout.phase * times[1]
    stance = np.zeros((2 * half, 2))
    stance[:half, 0] = stance[half:, 1] = 1.0
    roll = rolls(problem, variables)
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
        "efforts": with_upper_feet(trajectory.efforts),
        "ground_wrench": trajectory.wrench,
        "swing_foot": trajectory.swing_foot,
        "roll": roll,
        DECOUPLING: decoupling(robot, _rooted(position, roll)),
    }


def _rooted(position: np.ndarray, roll: np.ndarray) -> np.ndarray:
    """Roll and driven joints (S, 11), stance leg first, reflected in right stance."""
    joints = position[:, list(ACTUATED)]
    half = len(joints) // 2
    joints = np.concatenate([joints[:half], reflected(joints[half:])])
    return np.concatenate([roll[..., 0].reshape(-1, 1), joints], axis=1)


def _report(
    problem: GaitProblem, solve: Solve, vx: float, vy: float, missed: float
) -> dict[str, Any]:
    return {
        "vx": vx,
        "vy": vy,
        "status": solve.status,
        "converged": solve.success,
        "iterations": solve.iterations,
        "attempts": [asdict(attempt) for attempt in solve.attempts],
        "cost": solve.cost,
        "cost_unit": COSTS[problem.config.cost].unit,
        "max_violation": max(solve.max_violation, missed),
        "residuals": solve.residuals | {DECOUPLING: missed},
        "between_nodes": dense_violations(problem, solve.variables),
        "coefficient_error": coefficients(problem, solve.variables)[1],
    }
