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
from slider.gait.formulation import Formulation
from slider.gait.problem import GaitProblem, build, worst_of
from slider.gait.rooted import DECOUPLING, decoupling
from slider.gait.solution import base_motion, coefficients, dense_violations, knee_trajectory
from slider.gait.solve import GaitSolver, PrimalDual, Solve
from slider.gait.transcription import ROLL_STATES
from slider.robot.kinematics import turn_to_heading, yaw_of
from slider.robot.knee_map import all_joints, prismatic_joints, reflected
from slider.robot.names import GAIT_JOINTS, LAST_JOINTS, NUM_JOINTS, VELOCITY, velocity_text
from slider.robot.transmission import Transmission

MIN_PENDING_JOBS = 50
"""Compile from this many pending gaits on: it takes 15 s and saves 0.6 s for each."""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Solve one gait; write its arrays as ``.npy`` and a report with residuals by name.

    It starts from the variables and multipliers of the input ``anchor``, if that converged.
    """
    solver, velocity = prepare(section, job)
    anchors = map(_optimum, inputs.get("anchor", ()))
    solve = solver.solve(*velocity, anchor=next(anchors, None))
    arrays, summary = write_report(section, solver.problem, solve, out, job)
    optimum = PrimalDual(solve.variables, solve.multipliers)._asdict()
    for name, array in (arrays | optimum).items():
        np.save(out / f"{name}.npy", array)
    return summary


def _optimum(folder: Path) -> PrimalDual | None:
    """Optimum of a gait; None if it did not converge."""
    if not json.loads((folder / REPORT).read_text(encoding="utf-8"))["converged"]:
        return None
    return PrimalDual(*(np.load(folder / f"{name}.npy") for name in PrimalDual._fields))


def prepare(section: Section, job: Job) -> tuple[GaitSolver, tuple[float, float, float]]:
    """Solver of a section, and its velocity [m/s, m/s, rad/s]."""
    vx, vy, yaw_rate = (float(value) for value in section["velocity"])
    config = from_dict(SolveConfig, section["solve"])
    robot = from_dict(Mechanism, section["robot"])
    settings = from_dict(FormulationConfig, section["formulation"])
    form = Formulation(robot, settings, yaw_rate != 0.0)
    problem = build(form, Compiled(job, "gaits", MIN_PENDING_JOBS))
    job.progress(f"gait {velocity_text((vx, vy, yaw_rate))}: built")
    return GaitSolver(problem, config.solver, config.step_time), (vx, vy, yaw_rate)


def write_report(
    section: Section, problem: GaitProblem, solve: Solve, out: Path, job: Job
) -> tuple[dict[str, np.ndarray], Summary]:
    """Write the report of a solve, record its CPU time; return arrays of the gait and summary."""
    vx, vy, yaw_rate = (float(value) for value in section["velocity"])
    job.metadata["solve_cpu"] = solve.cpu
    arrays = gait_arrays(problem, solve, section["solve"]["kinematic_map"], yaw_rate)
    least = section["solve"]["decoupling_min"]
    missing, worst = worst_of(arrays[DECOUPLING][:, 0], least, np.inf)
    report = {
        **dict(zip(VELOCITY, (vx, vy, yaw_rate), strict=True)),
        "status": solve.status,
        "converged": solve.success,
        "iterations": solve.iterations,
        "attempts": [asdict(attempt) for attempt in solve.attempts],
        "cost": solve.cost,
        "cost_unit": COSTS[problem.form.config.cost].unit,
        **_measures(problem.form, arrays, vx),
        "max_violation": max(solve.max_violation, missing),
        "residuals": solve.residuals | {DECOUPLING: missing},
        "worst": solve.worst | {DECOUPLING: worst},
        "between_nodes": dense_violations(problem, solve.variables, yaw_rate),
    }
    (out / REPORT).write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    names = (*VELOCITY, "status", "converged", "iterations", "cost", "max_violation")
    return arrays, {name: report[name] for name in names}


def _measures(form: Formulation, arrays: dict[str, np.ndarray], vx: float) -> dict[str, Any]:
    """Means over both steps: cost of transport of the motors [-], height of the base [m]."""
    motors, rates = Transmission.of(form.robot), arrays["samples"][:, NUM_JOINTS : 2 * NUM_JOINTS]
    power = np.abs(motors.torques(arrays["efforts"]) * motors.angles(rates)).sum(axis=1)
    power, height = (
        float(np.trapezoid(values.reshape(2, -1), axis=1).mean() * 2 / (len(values) - 2))
        for values in (power, arrays["base"][:, 2])
    )
    transport = power / form.weight / vx if vx > 0 else None
    return {"gait_transport": transport, "base_height": height}


def gait_arrays(
    problem: GaitProblem, solve: Solve, kinematic_map: str, yaw_rate: float = 0.0
) -> dict[str, np.ndarray]:
    """Arrays of a gait; see ``docs/reference/gait-library.md`` for shapes, units and frames.

    ``yaw_rate`` [rad/s] is the commanded one.
    """
    layout, variables = problem.layout, solve.variables
    walk = knee_trajectory(problem, variables)
    robot, half = problem.form.robot, layout.nodes
    position, velocity = prismatic_joints(walk.q, walk.v, robot, kinematic_map)
    efforts = all_joints(walk.efforts)
    for index, values in enumerate((position, velocity, efforts)):
        values[:, LAST_JOINTS] = walk.ankle_rolls[:, index]
    speeds = turn_to_heading(walk.base_velocity, yaw_of(walk.base_rotation))
    times = np.array([variables[layout.time_index(step)] for step in range(2)])
    first, second = layout.phase * times[0], times[0] + layout.phase * times[1]
    stance = np.zeros((2 * half, 2))
    stance[:half, 0] = stance[half:, 1] = 1.0
    roll = layout.node_vectors(variables)[..., :ROLL_STATES].copy()
    rooted = position[:, GAIT_JOINTS]  # stance leg first, reflected in right stance
    rooted[half:] = reflected(rooted[half:], robot.geometry)
    rooted = np.concatenate([roll[..., 0].reshape(-1, 1), rooted], axis=1)
    return {
        "samples": np.concatenate([position, velocity, speeds], axis=1),
        "time": np.concatenate([first, second]),
        "step_time": times,
        "coefficients": coefficients(problem, variables),
        "base": base_motion(walk, walk.swing_foot[half - 1, :2], yaw_rate * times[0]),
        "contact": stance,
        "knee_positions": walk.q,
        "knee_velocities": walk.v,
        "knee_torques": walk.torques,
        "efforts": efforts,
        "ground_wrench": walk.wrench,
        "swing_foot": walk.swing_foot,
        "roll": roll,
        DECOUPLING: decoupling(robot, rooted),
    }
