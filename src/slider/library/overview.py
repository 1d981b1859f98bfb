"""Summaries of a gait and of a library for the terminal."""

from collections.abc import Sequence

import numpy as np

from slider.library import measures
from slider.library.reader import GaitLibrary
from slider.robot.names import CHANNELS, MOTORS, velocity_text
from slider.robot.transmission import Transmission

_WORST = 5  # constraints that are shown by name


def gait_lines(library: GaitLibrary, gait: int) -> list[str]:
    """Status, times, cost, peaks against the limits, worst residuals and clearance of a gait."""
    arrays = library.arrays
    first, second = arrays["step_time"][gait]
    swing = arrays["swing_foot"][gait, :, 0]  # forward of the stance foot [m]
    lines = [
        f"gait {velocity_text(library.velocities[gait])}: {arrays['status'][gait]}, "
        f"{arrays['iterations'][gait]} iterations",
        f"  step time    {first:.3f} s left stance, {second:.3f} s right stance",
        f"  step length  {swing[len(swing) // 2 - 1]:.3f} m, {swing[-1]:.3f} m forward",
        f"  cost         {arrays['cost'][gait]:.6g} {library.cost_unit}",
        f"  clearance    {100 * measures.clearance(library, gait):.1f} cm at mid-step "
        "(lower end of the swing foot)",
        "  peaks",
    ]
    torque, voltage = (shares[gait] for shares in measures.motor_shares(library))
    limits = Transmission.of(library.robot).torque
    for quantity, shares, most, unit in (
        ("torque", torque, limits, "N m"),
        ("voltage", voltage, np.ones_like(voltage), "of the bus"),
    ):
        motor = int(shares.argmax())
        peak = f"{shares[motor] * most[motor]:8.2f} of {most[motor]:g} {unit}"
        lines.append(
            f"    {quantity:<12}{peak:<26}{f'{100 * shares[motor]:.0f} %':>6}  {MOTORS[motor]}"
        )
    return [*lines, "  worst residuals [SI unit of the constraint]", *_residuals(library, gait)]


def library_lines(library: GaitLibrary) -> list[str]:
    """Grid, convergence, holes with what they violate, ranges, worst residual, smoothness."""
    mesh = library.mesh
    return [
        f"gait library: {len(library)} of {len(library) + len(library.holes)} gaits converged",
        f"  vx {_axis(mesh.vx)} m/s",
        f"  vy {_axis(mesh.vy)} m/s",
        *([f"  yaw rate {_axis(mesh.yaw_rate)} rad/s"] if mesh.yaw_rate.any() else []),
        *(f"  hole {velocity_text(hole.velocity)}: {hole.reason}" for hole in library.holes),
        *_ranges(library),
        _worst_residual(library),
        _smoothness(library),
    ]


def _residuals(library: GaitLibrary, gait: int) -> list[str]:
    values = library.arrays["residuals"][gait]
    worst = np.argsort(-values, kind="stable")[:_WORST]
    return [f"    {library.constraints[i]:<24}{values[i]:.1e}" for i in worst]


def _axis(values: np.ndarray) -> str:
    """Runs of equal steps: ``0 … 1.2 every 0.05, 1.3 … 3 every 0.1``."""
    if len(values) == 1:
        return f"{values[0]:g}"
    texts, start = [], 0
    steps = np.round(np.diff(values), 9)
    while start < len(values):
        stop = start
        while stop < len(steps) and steps[stop] == steps[start]:
            stop += 1
        run = values[start : stop + 1]
        if len(run) < 3:
            texts += [f"{value:g}" for value in run]
        else:
            texts.append(f"{run[0]:g} … {run[-1]:g} every {run[1] - run[0]:.4g}")
        start = stop + 1
    return ", ".join(texts)


def _ranges(library: GaitLibrary) -> list[str]:
    arrays = library.arrays
    rows: list[tuple[str, Sequence[float] | np.ndarray, str]] = [
        ("step time", arrays["step_time"], "s"),
        ("cost", arrays["cost"], library.cost_unit),
        ("iterations", arrays["iterations"], ""),
        ("motor torque", 100 * measures.torque_share(library), "% of limit"),
        ("motor voltage", 100 * measures.voltage_share(library), "% of the bus"),
        ("slide speed", measures.slide_speed(library), "m/s"),
        ("clearance", [100 * measures.clearance(library, i) for i in range(len(library))], "cm"),
    ]
    header = f"  {'':<18}{'least':>10}{'median':>10}{'greatest':>10}"
    lines = [header]
    for name, values, unit in rows:
        spread = "".join(f"{f(values):>10.4g}" for f in (np.min, np.median, np.max))
        lines.append(f"  {name:<18}{spread}  {unit}")
    return lines


def _worst_residual(library: GaitLibrary) -> str:
    residuals = library.arrays["residuals"]
    gait, constraint = np.unravel_index(residuals.argmax(), residuals.shape)
    name, velocity = library.constraints[constraint], velocity_text(library.velocities[gait])
    return f"  worst residual: {name} {residuals.max():.1e} at {velocity}"


def _smoothness(library: GaitLibrary) -> str:
    measured = measures.smoothness(library.velocities, library.arrays["samples"])
    if not len(measured.pairs):
        return "  smoothness: no neighbouring gaits"
    first, second, channel = measured.worst
    ends = [velocity_text(library.velocities[index]) for index in (first, second)]
    return (
        f"  smoothness: greatest jump {100 * measured.largest:.1f} % of the range of "
        f"{CHANNELS[channel]}, between {ends[0]} and {ends[1]}"
    )
