"""The study of the gait optimisation as Markdown: its tables, and what they say."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slider.evaluation.results import wilson
from slider.reports.controllers import speed
from slider.reports.quantities import NONE, Quantity
from slider.reports.rows import Row, by
from slider.reports.table import Heading, Picture, Text, Written, grid, listed

LIBRARY, TIME = "library", "solve_cpu"  # the start that is no random one; no column of the CSVs
_ROLL_EQUATION = "between_foot_line_moment"
_SHARE = Quantity("", "%", 100.0)
_MESH = (
    *("command [m/s]", "nodes", "converges", "iterations", "∫ cost [N² m²]", "to the finest"),
    *("step time [s]", "worst residual", "roll equation [N m]", "other bounds"),
    *("joints [rad]", "roll [rad]", "roll at the end [rad]", "time [s]"),
)
_STARTS = (
    *("command [m/s]", "starts", "converge [%]", "reach the best [%]", "optima"),
    *("library above the best", "iterations", "time [s]"),
)


def blocks(
    meshes: Sequence[Row], starts: Sequence[Row], study: Mapping[str, Any], svg: Path
) -> Iterator[Written]:
    """The figure and a table of each part."""
    yield Picture(svg)
    yield Heading("Meshes")
    yield Text(
        "The same problem on every mesh, from the library's own guesses. ∫ cost is "
        "(1/T) ∫ ‖τ‖² dt of both steps, whatever the optimisation minimises. The worst residual is "
        "that of the nodes, in the unit of its constraint. Between the nodes the roll equation "
        "leaves a moment about the foot line; of the other bounds the worst violation is named. "
        "Joints and roll are the greatest differences from the finest mesh at common phases. "
        "Time is IPOPT's processor time."
    )
    yield grid(_MESH, [_mesh(row) for row in meshes])
    yield Heading("Random starts")
    yield Text(_drawn(study))
    groups = by(starts, "command")
    yield grid(_STARTS, [_start(v, mine, study["same_cost"]) for v, mine in groups.items()])
    yield Text(verdict(starts, study["same_cost"]))


def verdict(starts: Sequence[Row], same: float) -> str:
    """Plain sentences, from the data: what failed, and whether the library's gait is the best."""
    where: dict[str, list[str]] = {}
    for command, (own, *drawn) in by(starts, "command").items():
        for found in (*_failures(drawn), _compared(own["cost_excess"], same)):
            where.setdefault(found, []).append(speed(command))
    return " ".join(f"At {listed(at)} m/s {found}." for found, at in where.items())


def _failures(drawn: Sequence[Row]) -> Iterator[str]:
    failed = Counter(row["status"] for row in drawn if not row["converged"])
    if failed:
        causes = ", ".join(f"{name} {count}" for name, count in failed.most_common())
        yield f"{failed.total()} of {len(drawn)} starts did not converge ({causes})"


def _compared(excess: float, same: float) -> str:
    """Of the library's gait, by what share it costs more than the best one."""
    if math.isnan(excess):
        return "the library's own guesses do not converge"
    if excess <= same:
        return "no start finds a better gait than the library's"
    return f"the library's gait costs {_percent(excess)} more than the best one found"


def _drawn(study: Mapping[str, Any]) -> str:
    starts, spread = study["starts"], study["starts"]["spread"]
    crouch, stride = (
        f"{spread[n]['lower']:g} to {spread[n]['upper']:g}" for n in ("crouch", "stride")
    )
    return (
        f"{starts['number']} starts per velocity from seed {starts['seed']}, each solved alone: "
        f"every Bézier coefficient within ±{spread['joints']:g} rad of a walk with {crouch} rad of "
        f"crouch and {stride} of the commanded step length, the step time anywhere in its bounds. "
        "A start converges if IPOPT says so and the worst residual is one that the library takes. "
        f"It reaches the best if its cost is within {study['same_cost']:g} of the cheapest found. "
        "Optima are groups of costs that lie further apart."
    )


def _mesh(row: Row) -> list[str]:
    others = {n: v for n, v in row.items() if n.startswith("between_") and n != _ROLL_EQUATION}
    name = max(others, key=others.__getitem__)
    worst = f"{_short(others[name])} {name.removeprefix('between_')}" if others[name] > 0 else "0"
    return [
        *(speed(row["command"]), f"{row['nodes']:g}", "yes" if row["converged"] else "no"),
        *(f"{row['iterations']:g}", f"{row['torque_cost']:.5g}"),
        _percent(row["torque_cost_difference"], "+"),
        *(f"{row['step_time']:.4g}", f"{row['max_violation']:.0e} {row['worst_constraint']}"),
        *(_short(row[_ROLL_EQUATION]), worst),
        *(_short(row[f"{name}_difference"]) for name in ("joints", "roll", "roll_end")),
        NONE if math.isnan(row[TIME]) else f"{row[TIME]:.3g}",
    ]


def _start(command: float, rows: Sequence[Row], same: float) -> list[str]:
    own, drawn = rows[0], rows[1:]
    good = [row for row in drawn if row["converged"]]
    best = [row for row in good if row["cost_excess"] <= same]
    optima = {row["optimum"] for row in rows if row["converged"]}
    return [
        *(speed(command), str(len(drawn)), _share(len(good), len(drawn))),
        *(_share(len(best), len(drawn)), str(len(optima)), _percent(own["cost_excess"])),
        *(_spread([row[name] for row in good]) for name in ("iterations", TIME)),
    ]


def _share(count: int, total: int) -> str:
    return _SHARE.between(count / total, *(wilson(count, total)))


def _spread(values: Sequence[float]) -> str:
    """Median, least and greatest."""
    known = [value for value in values if not math.isnan(value)]
    if not known:
        return NONE
    text, least, greatest = (f"{x:.3g}" for x in (np.median(known), min(known), max(known)))
    return text if least == greatest else f"{text} ({least}–{greatest})"


def _short(value: float) -> str:
    return NONE if math.isnan(value) else f"{value:.2g}"


def _percent(share: float, sign: str = "") -> str:
    if math.isnan(share):
        return NONE
    return f"{100 * share:{sign}.2g} %".replace("-", "−")
