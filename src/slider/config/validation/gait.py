"""Rules of the gait optimisation and of its independent checks."""

from slider.config.gait import Axis, GaitConfig, GridBlock, GridConfig, Posture, StepTime, axis_size
from slider.config.validation.checks import ordered, require
from slider.config.verification import RegulatorConfig

MAX_GRID = 5000


def check_gait(gait: GaitConfig) -> None:
    """A grid that can be solved, and limits that leave room between them."""
    _grid(gait.grid)
    _step_time(gait.step_time)
    ordered("gait.touchdown.down", gait.touchdown.down_min, gait.touchdown.down_max)
    _posture(gait.posture)


def check_regulator(regulator: RegulatorConfig) -> None:
    """One share forwards for each speed."""
    shares, speeds = regulator.forward, regulator.speeds
    expected = "one share for each of the `speeds`"
    found = f"{shares} at {speeds}"
    key = "verification.replay.regulator.forward"
    require(len(shares) == len(speeds), key, expected, found)


def _grid(grid: GridConfig) -> None:
    size = _block("gait.grid", grid)
    size += sum(_block(f"gait.grid.extra[{i}]", block) for i, block in enumerate(grid.extra))
    require(size <= MAX_GRID, "gait.grid", f"at most {MAX_GRID} commands", size)


def _block(key: str, block: GridBlock) -> int:
    return _axis(f"{key}.vx", block.vx) * _axis(f"{key}.vy", block.vy) * len(block.yaw_rate)


def _axis(key: str, axis: Axis | list[float]) -> int:
    if isinstance(axis, Axis):
        possible = axis.start <= axis.stop
        require(possible, key, "start ≤ stop, or a list", f"{axis.start} > {axis.stop}")
    return axis_size(axis)


def _step_time(time: StepTime) -> None:
    key = "gait.step_time"
    ordered(key, time.lower, time.upper)
    within = time.lower <= time.value <= time.upper
    require(within, f"{key}.value", f"from {time.lower} to {time.upper} s", time.value)


def _posture(posture: Posture) -> None:
    key = "gait.posture"
    clearance = posture.clearance + posture.clearance_margin
    expected = f"with its margin less than swing_height ({posture.swing_height} m)"
    require(clearance < posture.swing_height, f"{key}.clearance", expected, clearance)
    ordered(f"{key}.knee", posture.knee_min, posture.knee_max)
    separation = posture.foot_separation_min, posture.foot_separation_max
    ordered(f"{key}.foot_separation", *separation)
