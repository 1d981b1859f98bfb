"""Random initial guesses, and the stage ``gait_start`` that solves from one of them alone."""

from pathlib import Path

import numpy as np

from slider.config.convert import from_dict
from slider.config.gait import StartSpread, StepTime
from slider.core.job import Inputs, Job, Section, Summary
from slider.gait.guess import LEG, crouched_walk, variables_of
from slider.gait.problem import GaitProblem
from slider.gait.solve import duration_bounds
from slider.gait.stage import prepare, write_report


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Solve one gait from start ``index`` of a seed; write its report."""
    solver, command = prepare(section, job)
    start = section["start"]
    duration = duration_bounds(from_dict(StepTime, section["solve"]["step_time"]), *command[:2])
    spread = from_dict(StartSpread, start["spread"])
    generator = np.random.default_rng([start["seed"], start["index"]])
    guess = random_start(solver.problem, command[0], duration, spread, generator)
    solve = solver.solve(*command, start=guess)
    return write_report(section, solver.problem, solve, out, job)[1]


def random_start(
    problem: GaitProblem,
    vx: float,
    duration: tuple[float, float],
    spread: StartSpread,
    generator: np.random.Generator,
) -> np.ndarray:
    """Variables (size,) about a crouched walk at forward speed vx [m/s], within their bounds.

    ``duration``: bounds of the step time [s]. The two steps differ.
    """
    step_time = generator.uniform(*duration)
    crouch = generator.uniform(spread.crouch.lower, spread.crouch.upper)
    stride = vx * step_time * generator.uniform(spread.stride.lower, spread.stride.upper)
    walk = crouched_walk(stride / 2 / LEG, problem.config.degree + 1, crouch)
    noise = generator.uniform(-spread.joints, spread.joints, (2, *walk.shape))
    start = variables_of(problem.layout, walk + noise, step_time)
    return np.clip(start, *problem.variable_bounds(duration))
