"""What the independent checks of the gaits found: verdict, worst values, maps."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from slider.reports.figures.verification_maps import CAPTION, NAME, unit
from slider.reports.sections.sources import Sources
from slider.reports.table import Cell, Picture, Table, Text, Written
from slider.verification.quantities import QUANTITIES
from slider.verification.summary import place

_HOLDS = {None: "–", True: "yes", False: "NO"}
_SHOWN = 20  # failures


def blocks(sources: Sources) -> Iterator[Written]:
    """The verdict, the maps, and one row per quantity."""
    about = json.loads(sources.file("verification", "verification.json").read_text())
    failures = about["failures"]
    bounded = sum(found["bound"] is not None for found in about["quantities"].values())
    yield Text(
        f"{about['gaits']} gaits, checked by other means than those that made them: pinocchio and "
        "MuJoCo for the dynamics, another integrator for the orbit, a dense sampling between the "
        "nodes, a replay in simulation."
    )
    if failures:
        quantities = f"{bounded} quantities have one"
        yield Text(f"{len(failures)} values are beyond their bounds ({quantities}):", "failed")
        more = len(failures) - _SHOWN
        left = [f"and {more} more; `reports/verification.json` has all"] if more > 0 else []
        yield Text("\n".join(f"* {text}" for text in [*failures[:_SHOWN], *left]))
    else:
        yield Text(f"All {bounded} bounds hold.", "best")
    yield Picture(sources.file(NAME, f"{NAME}.svg"), CAPTION)
    yield Text(
        "Worst value over all gaits, the gait that has it, and the median; without a bound a "
        "quantity is reported only. The numbers of the checks are those of "
        "`docs/reference/verification.md`."
    )
    yield bounds_table(about["quantities"])


def bounds_table(quantities: Mapping[str, Mapping[str, Any]]) -> Table:
    """Worst value, bound, gait and median of each quantity of ``verification.json``."""
    columns = [
        "check",
        "quantity",
        "what it is",
        "unit",
        "worst",
        "bound",
        "holds",
        "at vx, vy [m/s]",
        "median",
    ]
    return Table(columns, [_row(name, found) for name, found in quantities.items()])


def _row(name: str, found: Mapping[str, Any]) -> list[Cell]:
    about, bound = QUANTITIES[name], found["bound"]
    sign = "≥" if about.at_least else "≤"
    return [
        Cell(str(about.check), about.check),
        Cell(name, name),
        Cell(about.meaning, about.meaning),
        Cell(unit(name)),
        _number(found["worst"]),
        Cell("–") if bound is None else Cell(f"{sign} {bound:g}", bound),
        Cell(_HOLDS[found["passed"]], failed=found["passed"] is False),
        Cell(place(found), found["vx"]),
        _number(found["median"]),
    ]


def _number(value: float | None) -> Cell:
    return Cell("not finite") if value is None else Cell(f"{value:.3g}", value)
