"""The ablation as Markdown: one table per number, variants below each other."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from slider.reports.controllers import speed
from slider.reports.seeds import Row, Spread, distinct, numbers, spread

LEARNED = 0.95  # share of robots that survive a check of a policy that has learned to walk

# Column of the table → heading.
METRICS = {
    "success_rate": "Success rate [%]",
    "mse_steady": "Velocity MSE from 2 s on [m²/s²]",
    "tracking_rate": "Tracking rate [%]",
    "alternation": "Touchdowns that follow one of the other foot [%]",
    "flight": "Flight [% of time]",
    "slip": "Slip of loaded heels and toes [m/s]",
    "clearance": "Clearance [m]",
    "asymmetry": "Asymmetry of step times [%]",
    "velocity_variance": "Variance of the forward velocity [m²/s²]",
    "cost_of_transport": "Cost of transport [-]",
}
_PERCENT = ("success_rate", "tracking_rate", "alternation", "flight", "asymmetry")


def markdown(
    name: str,
    rows: Sequence[Row],
    curves: Sequence[Row],
    variants: Mapping[str, Mapping[str, Any]],
) -> str:
    """Page with what the variants are, when they learned to walk, and a table per number."""
    commands = distinct(rows, "command_velocity")
    tables = [_table(rows, metric, variants, commands) for metric in METRICS]
    title = name.capitalize()
    return "\n".join(
        [f"# {title}", "", _caption(name, rows), "", f"![{title}](figures/{name}.png)", ""]
        + [_variants(curves, variants), *tables]
    )


def _caption(name: str, rows: Sequence[Row]) -> str:
    seeds = distinct(rows, "seed")
    over = f"mean of {len(seeds)} seeds (least to greatest)" if len(seeds) > 1 else "one seed"
    return (
        f"Every number: {over}; errors and gait quality are those of surviving robots. Where none "
        "of a seed survived, its error is ∞ and its gait quality is left out. "
        f"`reports/{name}.csv` has them all."
    )


def _variants(curves: Sequence[Row], variants: Mapping[str, Mapping[str, Any]]) -> str:
    lines = [
        f"| variant | samples until {100 * LEARNED:.0f} % of a check's robots survive [M] | "
        "overrides |",
        "|---|---|---|",
    ]
    for name, variant in variants.items():
        changes = " ".join(f"`{text}`" for text in variant["overrides"]) or "none"
        lines.append(f"| {variant['label']} | {learned(curves, name)} | {changes} |")
    return "\n".join([*lines, ""])


def learned(curves: Sequence[Row], variant: str) -> str:
    """Samples at which the seeds first pass ``LEARNED``, and how many never do."""
    found = first_learned(curves, variant)
    never = sum(math.isnan(value) for value in found)
    text = spread_text(spread(found), "samples")
    if not never:
        return text
    return "never" if never == len(found) else f"{text}; {never} of {len(found)} never"


def first_learned(curves: Sequence[Row], variant: str) -> list[float]:
    """For each seed millions of samples at which it first passes ``LEARNED``; NaN for never."""
    seeds = dict.fromkeys(str(row["seed"]) for row in curves if row["variant"] == variant)
    return [_first(curves, variant, seed) for seed in seeds]


def _first(curves: Sequence[Row], variant: str, seed: str) -> float:
    success = np.array(numbers(curves, "success", variant=variant, seed=seed))
    samples = np.array(numbers(curves, "samples", variant=variant, seed=seed))
    passed = np.flatnonzero(success >= LEARNED)
    return float(samples[passed[0]]) / 1e6 if len(passed) else math.nan


def _table(
    rows: Sequence[Row],
    name: str,
    variants: Mapping[str, Mapping[str, Any]],
    commands: Sequence[float],
) -> str:
    heads = " | ".join(f"{speed(command)} m/s" for command in commands)
    lines = [f"## {METRICS[name]}", "", f"| variant | {heads} |", "|---|" + "---|" * len(commands)]
    for variant, about in variants.items():
        found = [
            spread(numbers(rows, name, variant=variant, command_velocity=command))
            for command in commands
        ]
        cells = (spread_text(value, name) for value in found)
        lines.append(f"| {about['label']} | {' | '.join(cells)} |")
    if name == "velocity_variance":
        lines.append(f"| the library's gait | {' | '.join(reference(rows, commands))} |")
    return "\n".join([*lines, ""])


def reference(rows: Sequence[Row], commands: Sequence[float]) -> list[str]:
    """Velocity variance of the library's gait at each command; – without a gait."""
    column = "reference_velocity_variance"
    return [
        spread_text(spread(numbers(rows, column, command_velocity=command)[:1]), column)
        for command in commands
    ]


def spread_text(value: Spread | None, name: str) -> str:
    """Mean and range of a column as people read it; – without any."""
    if value is None:
        return "–"
    if value.count == 1:
        return _text(value.mean, name)
    return f"{_text(value.mean, name)} ({_text(value.lower, name)}–{_text(value.upper, name)})"


def _text(value: float, name: str) -> str:
    if math.isinf(value):
        return "∞"
    return f"{100 * value:.1f}" if name in _PERCENT else f"{value:.3g}"
