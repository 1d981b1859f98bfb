"""Checks of the gait optimisation: its grid, formulation and solver."""

from slider.config.gait import (
    Axis,
    GaitConfig,
    GridConfig,
    Posture,
    SolverConfig,
    StepTime,
    axis_size,
)
from slider.config.validation.checks import (
    at_least,
    one_of,
    ordered,
    positive,
    require,
    share,
    some,
)

MAX_GRID = 5000
MAX_NODES = 201


def check_gait(gait: GaitConfig) -> None:
    """Everything that a gait is solved with, and for how many velocities."""
    _grid(gait.grid)
    _nodes(gait.nodes)
    require(3 <= gait.degree <= 12, "gait.degree", "a degree from 3 to 12", gait.degree)
    one_of("gait.transcription", gait.transcription, ("bezier", "collocation"))
    one_of("gait.dynamics", gait.dynamics, ("prismatic", "knee"))
    one_of("gait.cost", gait.cost, ("paper", "torque", "transport"))
    one_of("gait.kinematic_map", gait.kinematic_map, ("exact", "paper"))
    _step_time(gait.step_time)
    ordered("gait.touchdown.down", gait.touchdown.down_min, gait.touchdown.down_max)
    _posture(gait.posture)
    share("gait.voltage", gait.voltage)
    positive("gait.contact.friction", gait.contact.friction)
    _solver(gait.solver)


def _grid(grid: GridConfig) -> None:
    size = _axis("gait.grid.vx", grid.vx) * _axis("gait.grid.vy", grid.vy)
    for index, block in enumerate(grid.extra):
        key = f"gait.grid.extra[{index}]"
        size += _axis(f"{key}.vx", block.vx) * _axis(f"{key}.vy", block.vy)
    require(size <= MAX_GRID, "gait.grid", f"at most {MAX_GRID} velocities", size)


def _axis(key: str, axis: Axis | list[float]) -> int:
    if isinstance(axis, Axis):
        positive(f"{key}.step", axis.step)
    size = axis_size(axis)
    require(size > 0, key, "start ≤ stop, or a list (a grid that is not empty)", axis)
    return size


def _nodes(nodes: int) -> None:
    allowed = 5 <= nodes <= MAX_NODES and nodes % 2 == 1
    require(allowed, "gait.nodes", f"an odd number from 5 to {MAX_NODES}", nodes)


def _step_time(time: StepTime) -> None:
    key = "gait.step_time"
    ordered(key, time.lower, time.upper)
    positive(f"{key}.lower", time.lower)
    one_of(f"{key}.law", time.law, ("free", "fixed", "speed"))
    within = time.lower <= time.value <= time.upper
    require(within, f"{key}.value", f"from {time.lower} to {time.upper} s", time.value)


def _posture(posture: Posture) -> None:
    key = "gait.posture"
    clearance = posture.clearance + posture.clearance_margin
    expected = f"with its margin less than swing_height ({posture.swing_height} m)"
    require(clearance < posture.swing_height, f"{key}.clearance", expected, clearance)
    ordered(f"{key}.knee", posture.knee_min, posture.knee_max)
    at_least(f"{key}.clearance_margin", posture.clearance_margin, 0)


def _solver(solver: SolverConfig) -> None:
    key = "gait.solver"
    at_least(f"{key}.max_iterations", solver.max_iterations, 1)
    some(f"{key}.guesses", solver.guesses, "rung")
    for rung in solver.guesses:
        one_of(f"{key}.guesses", rung, ("cold", "fast", "crouched", "ramp"))
    one_of(f"{key}.keep", solver.keep, ("first", "best"))
