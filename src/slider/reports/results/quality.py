"""How the policy walks: quantities down, commands across."""

from collections.abc import Sequence
from pathlib import Path

from slider.artefacts.store import Store
from slider.reports.controllers import label, speed
from slider.reports.results.markdown import grid, markdown
from slider.reports.results.numbers import Kind, Row, read, shown

_QUANTITIES = (  # title, column, how it is shown
    ("touchdowns that follow one of the other foot [%]", "alternation", Kind.SHARE),
    ("touchdowns [1/s]", "touchdown_rate", Kind.PLAIN),
    ("touchdowns of the library's gait [1/s]", "reference_touchdown_rate", Kind.PLAIN),
    ("asymmetry of step times [%]", "asymmetry", Kind.SHARE),
    ("flight [% of time]", "flight", Kind.SHARE),
    ("slip of loaded heels and toes [cm/s]", "slip", Kind.CENTI),
    ("foot clearance [cm]", "clearance", Kind.CENTI),
    ("least distance of the legs, worst robot [cm]", "leg_distance", Kind.CENTI),
    ("robots whose legs ever touch [%]", "robots_touch", Kind.SHARE),
    ("robots whose feet ever cross [%]", "robots_cross", Kind.SHARE),
    ("largest heading error, mean of the robots [rad]", "heading", Kind.PLAIN),
    ("largest heading error, worst robot [rad]", "heading_worst", Kind.PLAIN),
    ("variance of the forward velocity [m²/s²]", "velocity_variance", Kind.PLAIN),
    ("the same of the library's gait [m²/s²]", "reference_velocity_variance", Kind.PLAIN),
    ("peak motor torque, worst robot [% of its limit]", "peak_effort", Kind.SHARE),
    ("peak motor speed, worst robot [% of its limit]", "peak_speed", Kind.SHARE),
)
_COST = ("cost of transport [-]", "cost_of_transport", Kind.PLAIN)
_COST_OF = ("policy", "mpc_wbc_tuned")


def quality(report: Path, store: Store) -> str:
    """The policy's quantities, and the cost of transport of the tuned baseline beside its own."""
    rows = read(report)
    commands = sorted({float(row["command_velocity"]) for row in rows})
    body = [_row(rows, "policy", quantity, commands) for quantity in _QUANTITIES]
    present = {row["controller"] for row in rows}
    for controller in (name for name in _COST_OF if name in present):
        title, column, kind = _COST
        quantity = (f"{title}, {label(controller)}", column, kind)
        body.append(_row(rows, controller, quantity, commands))
    return markdown(grid(["command [m/s]", *map(speed, commands)], body))


def _row(
    rows: Sequence[Row], controller: str, about: tuple[str, str, Kind], commands: Sequence[float]
) -> list[str]:
    title, column, kind = about
    mine = {float(r["command_velocity"]): r for r in rows if r["controller"] == controller}
    found = [mine[command][column] if command in mine else "" for command in commands]
    return [title, *(shown(text, kind) for text in found)]
