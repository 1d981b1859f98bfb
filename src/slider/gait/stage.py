"""The stage ``gait``: one walk for one velocity."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.gait import FormulationConfig, SolveConfig
from slider.config.robot import Mechanism
from slider.core.casadi_code import Compiled
from slider.core.job import Inputs, Job, Section, Summary
from slider.gait import REPORT
from slider.gait.costs import COSTS
from slider.gait.formulation import formulate, least_hip_rate
from slider.gait.problem import GaitProblem, build, worst_of
from slider.gait.rooted import DECOUPLING, decoupling
from slider.gait.solution import (
    base_motion,
    coefficients,
    dense_violations,
    knee_trajectory,
    samples,
)
from slider.gait.solve import GaitSolver, Solve
from slider.gait.transcription import ROLL_STATES
from slider.robot.knee_map import prismatic_joints, reflected, with_upper_feet
from slider.robot.names import ACTUATED, VELOCITY, velocity_text

WORTH = 50
"""Gaits that pay for a compilation twice: it takes 15 s and saves each 0.6 s."""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Solve one gait; write its arrays as ``.npy`` and a report with residuals by name."""
    solver, velocity = prepare(section, job)
    solve = solver.solve(*velocity)
    arrays, summary = write_report(section, solver.problem, solve, out, job)
    for name, array in arrays.items():
        np.save(out / f"{name}.npy", array)
    return summary


def prepare(section: Section, job: Job) -> tuple[GaitSolver, tuple[float, float, float]]:
    """Solver of a section, and its velocity [m/s, m/s, rad/s]."""
    config = from_dict(SolveConfig, section["solve"])
    velocity = _velocity(section)
    robot = from_dict(Mechanism, section["robot"])
    formulation = from_dict(FormulationConfig, section["formulation"])
    hip_rate = least_hip_rate(formulation, velocity[0])
    form = formulate(robot, formulation, velocity[2] != 0.0, hip_rate)
    problem = build(form, Compiled(job, "gaits", WORTH))
    job.progress(f"gait {velocity_text(velocity)}: built")
    return GaitSolver(problem, config.solver, config.step_time), velocity


def write_report(
    section: Section, problem: GaitProblem, solve: Solve, out: Path, job: Job
) -> tuple[dict[str, np.ndarray], Summary]:
    """Write the report of a solve and note its times; arrays of the gait, and the summary."""
    velocity = _velocity(section)
    job.volatile.update(solve_cpu=solve.cpu, solve_wall=solve.wall, **solve.evaluations)
    arrays = gait_arrays(problem, solve, section["solve"]["kinematic_map"], velocity[2])
    least = section["solve"]["decoupling_min"]
    report = _report(problem, solve, velocity, worst_of(arrays[DECOUPLING][:, 0], least, np.inf))
    (out / REPORT).write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    names = (*VELOCITY, "status", "converged", "cost", "max_violation")
    return arrays, {name: report[name] for name in names}


def _velocity(section: Section) -> tuple[float, float, float]:
    vx, vy, yaw_rate = (float(value) for value in section["velocity"])
    return vx, vy, yaw_rate


def gait_arrays(
    problem: GaitProblem, solve: Solve, kinematic_map: str, yaw_rate: float = 0.0
) -> dict[str, np.ndarray]:
    """Arrays of a gait; see ``docs/reference/gait-library.md`` for shapes, units and frames.

    ``yaw_rate`` [rad/s] is the commanded one.
    """
    layout, variables = problem.layout, solve.variables
    trajectory = knee_trajectory(problem, variables)
    robot, half = problem.form.robot, layout.nodes
    position, velocity = prismatic_joints(trajectory.q, trajectory.v, robot, kinematic_map)
    times = np.array([variables[layout.time_index(step)] for step in range(2)])
    first, second = layout.phase * times[0], times[0] + layout.phase * times[1]
    stance = np.zeros((2 * half, 2))
    stance[:half, 0] = stance[half:, 1] = 1.0
    roll = layout.node_vectors(variables)[..., :ROLL_STATES].copy()
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
        "roll": roll,
        DECOUPLING: decoupling(robot, _rooted(position, roll), problem.form.by_hip),
    }


def _rooted(position: np.ndarray, roll: np.ndarray) -> np.ndarray:
    """Roll and driven joints (S, 11), stance leg first, reflected in right stance."""
    joints = position[:, list(ACTUATED)]
    half = len(joints) // 2
    joints = np.concatenate([joints[:half], reflected(joints[half:])])
    return np.concatenate([roll[..., 0].reshape(-1, 1), joints], axis=1)


def _report(
    problem: GaitProblem, solve: Solve, velocity: tuple[float, ...], regular: tuple[float, str]
) -> dict[str, Any]:
    """``regular``: by how much the decoupling misses its bound, and both in words."""
    forward = knee_trajectory(problem, solve.variables).base_velocity[:, 0]
    return {
        **dict(zip(VELOCITY, velocity, strict=True)),
        "status": solve.status,
        "converged": solve.success,
        "iterations": solve.iterations,
        "attempts": [asdict(attempt) for attempt in solve.attempts],
        "cost": solve.cost,
        "cost_unit": COSTS[problem.config.cost].unit,
        "hip_share": float(forward.min()) / velocity[0] if velocity[0] > 0 else None,
        "max_violation": max(solve.max_violation, regular[0]),
        "residuals": solve.residuals | {DECOUPLING: regular[0]},
        "worst": solve.worst | {DECOUPLING: regular[1]},
        "between_nodes": dense_violations(problem, solve.variables, velocity[2]),
        "coefficient_error": coefficients(problem, solve.variables)[1],
    }
