"""A gait or a library for people and other programs: summaries as text, one gait as CSV.

Columns of the file are in ``docs/reference/gait-library.md``.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from slider.library import measures, reader
from slider.library.reader import ARRAYS, GaitLibrary
from slider.robot import names as of_robot
from slider.robot.names import channel_units, channels, velocity_text
from slider.robot.transmission import Transmission

_WORST = 5  # constraints that are shown by name
_BASE_UNITS = ("m",) * 3 + ("1",) * 4 + ("m/s",) * 3 + ("rad/s",) * 3
_WRENCH_UNITS = ("N",) * 3 + ("N m",) * 3


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
    names = of_robot.motor_names(library.robot.geometry)
    for quantity, shares, most, unit in (
        ("torque", torque, limits, "N m"),
        ("voltage", voltage, np.ones_like(voltage), "of the bus"),
    ):
        motor = int(shares.argmax())
        peak = f"{shares[motor] * most[motor]:8.2f} of {most[motor]:g} {unit}"
        lines.append(
            f"    {quantity:<12}{peak:<26}{f'{100 * shares[motor]:.0f} %':>6}  {names[motor]}"
        )
    lines.append("  worst residuals [SI unit of the constraint]")
    residuals = arrays["residuals"][gait]
    worst = np.argsort(-residuals, kind="stable")[:_WORST]
    return lines + [f"    {library.constraints[i]:<24}{residuals[i]:.1e}" for i in worst]


def library_lines(library: GaitLibrary) -> list[str]:
    """Convergence, holes with what they violate, ranges, worst residual, smoothness."""
    mesh, arrays = library.mesh, library.arrays
    torque, voltage = measures.motor_shares(library)
    clearances = [100 * measures.clearance(library, i) for i in range(len(library))]
    geometry = library.robot.geometry
    names = channels(geometry)
    slide_unit = channel_units(geometry)[names.index("left_slide.velocity")]
    lines = [
        f"gait library: {len(library)} of {len(library) + len(library.holes)} gaits converged",
        *(f"  hole {velocity_text(hole.velocity)}: {hole.reason}" for hole in library.holes),
        f"  {'':<18}{'least':>10}{'median':>10}{'greatest':>10}",
    ]
    for name, values, unit in (
        ("vx", mesh.vx, "m/s"),
        ("vy", mesh.vy, "m/s"),
        ("yaw rate", mesh.yaw_rate, "rad/s"),
        ("step time", arrays["step_time"], "s"),
        ("cost", arrays["cost"], library.cost_unit),
        ("iterations", arrays["iterations"], ""),
        ("motor torque", 100 * torque.max(axis=1), "% of limit"),
        ("motor voltage", 100 * voltage.max(axis=1), "% of the bus"),
        ("slide speed", measures.slide_speed(library), slide_unit),
        ("clearance", clearances, "cm"),
    ):
        spread = "".join(f"{f(values):>10.4g}" for f in (np.min, np.median, np.max))
        lines.append(f"  {name:<18}{spread}  {unit}")
    residuals = arrays["residuals"]
    gait, constraint = np.unravel_index(residuals.argmax(), residuals.shape)
    at = f"{residuals.max():.1e} at {velocity_text(library.velocities[gait])}"
    lines.append(f"  worst residual: {library.constraints[constraint]} {at}")
    measured = measures.smoothness(library.velocities, arrays["samples"])
    if not len(measured.pairs):
        return [*lines, "  smoothness: no neighbouring gaits"]
    *pair, channel = measured.worst
    first, second = (velocity_text(library.velocities[index]) for index in pair)
    jump = f"{100 * measured.largest:.1f} % of the range of {names[channel]}"
    return [*lines, f"  smoothness: greatest jump {jump}, between {first} and {second}"]


def write_csv(library: GaitLibrary, gait: int, path: Path) -> None:
    """Write one row per sample; the header names each column with its unit in brackets."""
    arrays = {name: library.arrays[name][gait] for name in ARRAYS}
    stance = [of_robot.SIDES[side] for side in arrays["contact"].argmax(axis=1)]
    columns: dict[str, list[str] | np.ndarray] = {"time [s]": arrays["time"], "stance": stance}
    geometry = library.robot.geometry
    sample_units = channel_units(geometry)
    effort_units = ["N" if unit == "m" else "N m" for unit in sample_units[: of_robot.NUM_JOINTS]]
    for array, texts, units in (
        ("samples", channels(geometry), sample_units),
        ("base", [f"base_motion.{name}" for name in reader.BASE_CHANNELS], _BASE_UNITS),
        ("efforts", [f"{name}.effort" for name in of_robot.joint_names(geometry)], effort_units),
        ("ground_wrench", [f"ground.{n}" for n in reader.WRENCH_COMPONENTS], _WRENCH_UNITS),
    ):
        for label, unit, values in zip(texts, units, arrays[array].T, strict=True):
            columns[f"{label} [{unit}]"] = values
    pd.DataFrame(columns).to_csv(path, index=False, float_format="%.10g", lineterminator="\n")
