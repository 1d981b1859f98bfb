"""The sensitivity as Markdown: which guesses carry the result, and tables."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from slider.reports.controllers import speed
from slider.reports.quantities import NONE, QUANTITIES, Quantity
from slider.reports.rows import Row
from slider.reports.sensitivity_effects import (
    NOMINAL,
    SUCCESS,
    Cell,
    Effect,
    carrying,
    effects,
    limit,
    nominals,
)
from slider.reports.table import Heading, Picture, Table, Text, Written, grid, listed

STRONGEST = 20  # rows of the table
NAMED = 6  # causes that a sentence names
_UNCHANGED = {  # column of the rows → heading
    "command": Quantity("Command", "m/s"),
    "gait_converged": Quantity("Gait converges"),
    "gait_iterations": Quantity("Iterations"),
    "gait_cost": Quantity("Cost"),
    "success_rate": QUANTITIES["success_rate"],
    "mse_steady": QUANTITIES["mse_steady"],
    "mean_velocity": QUANTITIES["mean_velocity"],
}


def blocks(rows: Sequence[Row], section: Mapping[str, Any], svg: Path) -> Iterator[Written]:
    """A paragraph, the figure and tables."""
    found = effects(rows)
    yield Text(_introduction(found, section))
    yield Heading("Which guesses carry the result")
    yield Text(verdict(rows))
    yield Picture(svg)
    yield Heading(f"The strongest {min(STRONGEST, len(found))} of {len(found)} parameters")
    yield Text(_legend(section["change"]))
    yield _strongest(found[:STRONGEST], rows, section)
    yield _unchanged(rows)
    yield from _impossible(found)


def verdict(rows: Sequence[Row]) -> str:
    """Plain sentences, from the data, on the guesses that carry the result."""
    found, nominal = effects(rows), nominals(rows)
    carry = carrying(found, nominal)
    sentences = [
        _count(carry, found),
        *_limits_of_the_unchanged(rows),
        *_lost(carry),
        *_falls(carry, nominal),
        *_rest([effect for effect in found if effect not in carry], bool(carry)),
        *_no_robots(found),
    ]
    return " ".join(sentences)


def _introduction(found: Sequence[Effect], section: Mapping[str, Any]) -> str:
    low, high = 1 - section["change"], 1 + section["change"]
    tags = ", ".join(dict.fromkeys(v["provenance"] for v in section["variants"]))
    skipped = section["skipped"]
    zeros = ", ".join(f"`{name}`" for name in skipped)
    return (
        f"{len(found)} parameters of the robot (provenance: {tags}) are multiplied by {low:g} and "
        f"by {high:g}, one at a time; {len(skipped)} of value zero were left out"
        f"{f' ({zeros})' if skipped else ''}. {_asked(found, section)}"
        "`sensitivity.csv` has every number."
    )


def _asked(found: Sequence[Effect], section: Mapping[str, Any]) -> str:
    gaits = "Each changed robot gets its own gaits. "
    policy = (
        f"The policy is not retrained: {section['robots']} robots walk for "
        f"{section['duration']:g} s at each command. "
    )
    has_gaits, has_policy = (any(getattr(e, kind) for e in found) for kind in ("gaits", "success"))
    return (gaits if has_gaits else "") + (policy if has_policy else "")


def _count(carry: Sequence[Effect], found: Sequence[Effect]) -> str:
    if not carry:
        return f"No parameter of {len(found)} carries the result."
    names = listed(f"`{effect.parameter}`" for effect in carry)
    verb = "carries" if len(carry) == 1 else "carry"
    return f"{len(carry)} of {len(found)} parameters {verb} the result: {names}."


def _limits_of_the_unchanged(rows: Sequence[Row]) -> Iterator[str]:
    for command, converged in nominals(rows, "gait_converged").items():
        if converged == 0:
            yield (
                f"The gait of the unchanged robot does not converge at {speed(command)} m/s, so "
                "gaits are not compared there."
            )
    for command, success in nominals(rows).items():
        if success < SUCCESS:
            yield (
                f"On the unchanged robot the policy survives in {_percent(success)} at "
                f"{speed(command)} m/s; below {_percent(limit(success))} counts there."
            )


def _lost(carry: Sequence[Effect]) -> Iterator[str]:
    for command in _commands(cell for effect in carry for cell in effect.gaits):
        causes = [_cause(e, cell) for e in carry for cell in e.lost if cell[1] == command]
        if causes:
            yield f"The gait at {speed(command)} m/s does not converge with {_some(causes)}."


def _falls(carry: Sequence[Effect], nominal: Mapping[float, float]) -> Iterator[str]:
    for command in _commands(cell for effect in carry for cell in effect.success):
        found = [
            (success, _cause(effect, cell))
            for effect in carry
            for cell, success in effect.falls(nominal).items()
            if cell[1] == command
        ]
        causes = [f"{cause} ({_percent(success)})" for success, cause in sorted(found)]
        if causes:
            yield (
                f"At {speed(command)} m/s the policy survives in less than "
                f"{_percent(limit(nominal[command]))} with {_some(causes)}."
            )


def _rest(others: Sequence[Effect], some: bool) -> Iterator[str]:
    """Of parameters that do not carry the result; ``some`` others do."""
    costs = [(abs(c), e, cell) for e in others for cell, c in e.costs.items()]
    if costs:
        cost, effect, cell = max(costs, key=lambda item: item[0])
        where = f"{_cause(effect, cell)} at {speed(cell[1])} m/s"
        most = f", most with {where}" if cost > 0 else ""
        which = f"the other {len(others)}" if some else "all of them"
        yield (
            f"With {which} the gaits converge, and their cost changes by at most "
            f"{_percent(cost)}{most}."
        )
    success = [value for effect in others for value in effect.success.values()]
    if success:
        least = "" if min(success) == 1 else "at least "
        yield f"The policy survives with these in {least}{_percent(min(success))}."


def _no_robots(found: Sequence[Effect]) -> Iterator[str]:
    names = [f"`{e.parameter}` × {factor:g}" for e in found for factor in e.impossible]
    if names:
        yield f"There is no robot with {listed(names)}; the reason stands below."


def _cause(effect: Effect, cell: Cell) -> str:
    return f"`{effect.parameter}` × {cell[0]:g}"


def _some(causes: Sequence[str]) -> str:
    """The first causes, and how many there are besides."""
    more = len(causes) - NAMED
    return listed([*causes[:NAMED], *([f"{more} more"] if more > 0 else [])])


def _commands(cells: Iterable[Cell]) -> list[float]:
    return sorted({command for _, command in cells})


def _legend(change: float) -> str:
    return (
        f"Two numbers of a cell: the parameter × {1 - change:g} and × {1 + change:g}. Gait: "
        "change of its cost; ✗ does not converge. Policy: success rate. – has no robot, or was "
        "not asked for."
    )


def _strongest(found: Sequence[Effect], rows: Sequence[Row], section: Mapping[str, Any]) -> Table:
    factors = (round(1 - section["change"], 10), round(1 + section["change"], 10))
    about = {row["parameter"]: row for row in rows}
    columns = [("gait", _gait)] if any(effect.gaits for effect in found) else []
    columns += [("policy", _policy)] if any(effect.success for effect in found) else []
    asked = [(what, text, v) for what, text in columns for v in section["commands"]]
    lines = []
    for effect in found:
        row = about[effect.parameter]
        cells = [" / ".join(text(effect, (f, v)) for f in factors) for _, text, v in asked]
        value = f"{row['nominal']} {row['unit']}".removesuffix(" -").strip()
        lines.append([f"`{effect.parameter}`", value, *cells])
    return grid(["parameter", "value", *(f"{what}, {speed(v)} m/s" for what, _, v in asked)], lines)


def _gait(effect: Effect, cell: Cell) -> str:
    if cell in effect.costs:
        return f"{100 * effect.costs[cell]:+.1f} %".replace("-", "−")
    return "✗" if effect.gaits.get(cell) is False else NONE


def _policy(effect: Effect, cell: Cell) -> str:
    return _percent(effect.success[cell]) if cell in effect.success else NONE


def _unchanged(rows: Sequence[Row]) -> Table:
    lines = [
        [_number(row[name], name) for name in _UNCHANGED]
        for row in rows
        if row["parameter"] == NOMINAL
    ]
    heads = [quantity.heading for quantity in _UNCHANGED.values()]
    return grid(heads, lines, "The unchanged robot")


def _number(value: float, name: str) -> str:
    if name == "gait_converged" and not math.isnan(value):
        return "yes" if value else "no"
    if name in ("command", "gait_iterations", "gait_cost") and not math.isnan(value):
        return f"{value:.6g}"
    return _UNCHANGED[name].text(value)


def _impossible(found: Sequence[Effect]) -> Iterator[Heading | Text]:
    lines = [
        f"* `{effect.parameter}` × {factor:g}: {note}"
        for effect in found
        for factor, note in effect.impossible.items()
    ]
    if lines:
        yield Heading("Robots that cannot be")
        yield Text("\n".join(lines))


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"
