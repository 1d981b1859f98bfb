"""The ablation: when its variants learned to walk, and a table per number."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from slider.reports.ablation import NAME
from slider.reports.ablation_text import (
    LEARNED,
    METRICS,
    first_learned,
    learned,
    reference,
    spread_text,
)
from slider.reports.controllers import speed
from slider.reports.page import Cell, Section, Table, picture
from slider.reports.sections.sources import Sources
from slider.reports.seeds import Row, distinct, numbers, spread

_CAPTION = "Learning curves of the variants above; survival, error and quality of the walk below."


def section(sources: Sources) -> Section:
    """The figure, the variants, and a table per number with variants down and commands across."""
    rows = _read(sources.file("ablation", f"{NAME}.csv"))
    curves = _read(sources.file("ablation", f"{NAME}_curves.csv"))
    settings = sources.configuration["ablation"]
    variants = {name: settings["variants"][name] for name in settings["run"]}
    drawing = sources.file("ablation", f"{NAME}.svg")
    values = {
        "samples": settings["samples"],
        "seeds": len(settings["seeds"]),
        "picture": picture(drawing, "Figure: the ablation", _CAPTION),
        "variants": _variants(curves, variants),
        "tables": [_table(rows, name, variants) for name in METRICS],
    }
    return Section("Ablation", "ablation.html", values)


def _read(path: Path) -> list[Row]:
    """Rows of a table of the ablation; all but names are numbers where there is one."""
    with path.open(newline="") as file:
        return [
            {k: v if k in ("variant", "seed") or not v else float(v) for k, v in row.items()}
            for row in csv.DictReader(file)
        ]


def _variants(curves: Sequence[Row], variants: Mapping[str, Mapping[str, Any]]) -> Table:
    share = f"samples until {100 * LEARNED:.0f} % of a check's robots survive [M]"
    rows = []
    for name, about in variants.items():
        found = spread(first_learned(curves, name))
        rows.append(
            [
                Cell(about["label"], about["label"]),
                Cell(learned(curves, name), found.mean if found else ""),
                Cell(" ".join(about["overrides"]) or "none"),
            ]
        )
    return Table(["variant", share, "overrides"], rows, "Variants")


def _table(rows: Sequence[Row], metric: str, variants: Mapping[str, Mapping[str, Any]]) -> Table:
    commands = distinct(rows, "command_velocity")
    body = [
        [
            Cell(about["label"], about["label"]),
            *(_cell(rows, metric, variant, command) for command in commands),
        ]
        for variant, about in variants.items()
    ]
    if metric == "velocity_variance":
        body.append([Cell("the library's gait"), *map(Cell, reference(rows, commands))])
    heads = ["variant", *(f"{speed(command)} m/s" for command in commands)]
    return Table(heads, body, METRICS[metric])


def _cell(rows: Sequence[Row], metric: str, variant: str, command: float) -> Cell:
    found = spread(numbers(rows, metric, variant=variant, command_velocity=command))
    text = spread_text(found, metric)
    return Cell(text) if found is None else Cell(text, found.mean)
