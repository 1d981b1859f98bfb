"""Seeds of the default training: median, least and greatest, commands across."""

from collections.abc import Sequence
from pathlib import Path
from statistics import median

from slider.artefacts.store import Store
from slider.reports.controllers import speed
from slider.reports.results.markdown import grid, markdown
from slider.reports.results.numbers import NONE, Kind, Row, read, shown

_QUANTITIES = (  # title, column, how it is shown
    ("success [%]", "success_rate", Kind.SHARE),
    ("tracking [%]", "tracking_rate", Kind.SHARE),
    ("MSE from 2 s on [m²/s²]", "mse_steady", Kind.PLAIN),
    ("MSE over all 10 s [m²/s²]", "mse", Kind.PLAIN),
    ("touchdowns that follow one of the other foot [%]", "alternation", Kind.SHARE),
    ("flight [% of time]", "flight", Kind.SHARE),
    ("slip of loaded heels and toes [cm/s]", "slip", Kind.CENTI),
    ("largest heading error, worst robot [rad]", "heading_worst", Kind.PLAIN),
    ("robots whose feet ever cross [%]", "robots_cross", Kind.SHARE),
    ("cost of transport [-]", "cost_of_transport", Kind.PLAIN),
)


def seeds(report: Path, store: Store) -> str:
    """Of the first variant the median of the seeds, and the least to the greatest of them."""
    rows = read(report)
    rows = [row for row in rows if row["variant"] == rows[0]["variant"]]
    commands = sorted({float(row["command_velocity"]) for row in rows})
    body = [
        [title, *(_cell(rows, column, command, kind) for command in commands)]
        for title, column, kind in _QUANTITIES
    ]
    names = sorted({row["seed"] for row in rows}, key=int)
    intro = f"Trainings from the seeds {', '.join(names)}: median (least to greatest)."
    return f"{intro}\n\n{markdown(grid(['command [m/s]', *map(speed, commands)], body))}"


def _cell(rows: Sequence[Row], column: str, command: float, kind: Kind) -> str:
    found = [r[column] for r in rows if float(r["command_velocity"]) == command and r[column]]
    if not found:
        return NONE
    values = sorted(map(float, found))
    texts = [shown(str(value), kind) for value in (median(values), values[0], values[-1])]
    return texts[0] if texts[1] == texts[2] else f"{texts[0]} ({texts[1]}–{texts[2]})"
