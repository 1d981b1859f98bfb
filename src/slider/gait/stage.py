"""The stage ``gait``: one walk for one commanded velocity."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from slider.core.config.convert import from_dict
from slider.core.config.gait import FormulationConfig
from slider.core.config.robot import Geometry, JointLimits, Links, VirtualKnee
from slider.core.job import Inputs, Job, Section, Summary
from slider.gait.formulation import Formulation
from slider.gait.problem import GaitProblem
from slider.gait.solution import base_motion, knee_trajectory, prismatic_joints, samples
from slider.gait.solve import GaitSolver, Solve
from slider.gait.tree import NUM_JOINTS, StanceTree
from slider.robot.knee_model import build_knee_model

REPORT = "report.json"


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Solve one gait; write its arrays as ``.npy`` and a report with residuals by name."""
    robot = section["robot"]
    geometry, links = from_dict(Geometry, robot["geometry"]), from_dict(Links, robot["links"])
    knee = from_dict(VirtualKnee, robot["virtual_knee"])
    limits = {name: from_dict(JointLimits, value) for name, value in robot["limits"].items()}
    config = from_dict(FormulationConfig, section["gait"])
    tree = StanceTree(build_knee_model(geometry, links, knee))
    problem = GaitProblem(Formulation(tree, config, limits, geometry.leg_length))
    vx, vy = (float(v) for v in section["velocity"])
    job.progress(f"gait ({vx:g}, {vy:g}) m/s: built")
    solve = GaitSolver(problem).solve(vx, vy)
    job.volatile.update(solve_cpu=solve.cpu, solve_wall=solve.wall)
    for name, array in gait_arrays(problem, solve, geometry.leg_length).items():
        np.save(out / f"{name}.npy", array)
    report = _report(solve, vx, vy)
    (out / REPORT).write_text(json.dumps(report, indent=1) + "\n")
    return {k: report[k] for k in ("vx", "vy", "status", "converged", "cost", "max_violation")}


def gait_arrays(problem: GaitProblem, solve: Solve, leg_length: float) -> dict[str, np.ndarray]:
    """Arrays of a gait; see ``docs/gait-library.md`` for shapes, units and frames."""
    form = problem.formulation
    trajectory = knee_trajectory(problem, solve.variables)
    model, variant = form.tree.model, form.config.kinematic_map
    position, velocity, effort = prismatic_joints(
        trajectory, model.thigh, model.shank, leg_length, variant
    )
    times = np.array([solve.variables[problem.time_index(step)] for step in range(2)])
    first, second = form.phase * times[0], times[0] + form.phase * times[1]
    half = problem.nodes
    stance = np.zeros((2 * half, 2))
    stance[:half, 0] = stance[half:, 1] = 1.0
    return {
        "samples": samples(position, velocity, trajectory),
        "time": np.concatenate([first, second]),
        "step_time": times,
        "coefficients": _coefficients(problem, solve.variables),
        "base": base_motion(trajectory, trajectory.swing_foot[half - 1, :2]),
        "contact": stance,
        "knee_positions": trajectory.q,
        "knee_velocities": trajectory.v,
        "knee_torques": trajectory.torques,
        "efforts": effort,
        "ground_wrench": trajectory.wrench,
        "swing_foot": trajectory.swing_foot,
        "roll": _roll(problem, solve.variables),
    }


def _coefficients(problem: GaitProblem, variables: np.ndarray) -> np.ndarray:
    """Bézier coefficients (2, 10, degree + 1); the second step is reflected."""
    steps = variables.reshape(2, problem.step_size)[:, : problem.num_coefficients]
    return steps.reshape(2, NUM_JOINTS, problem.degree + 1)


def _roll(problem: GaitProblem, variables: np.ndarray) -> np.ndarray:
    """Roll, rate and acceleration (2, nodes, 3) of the stance foot; the second step reflected."""
    steps = variables.reshape(2, problem.step_size)[:, problem.num_coefficients + 1 :]
    return steps.reshape(2, problem.nodes, 3)


def _report(solve: Solve, vx: float, vy: float) -> dict[str, Any]:
    return {
        "vx": vx,
        "vy": vy,
        "status": solve.status,
        "converged": solve.success,
        "iterations": solve.iterations,
        "cost": solve.cost,
        "max_violation": solve.max_violation,
        "residuals": solve.residuals,
    }
