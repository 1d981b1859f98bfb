"""Summary of a library as text."""

import numpy as np

from slider.library import measures
from slider.library.reader import GaitLibrary
from slider.robot.names import channel_units, channels, velocity_text


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
