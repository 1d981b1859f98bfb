"""The stage ``ablation``: what each choice of the method is worth, as tables and a figure."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation import records
from slider.reports import ablation_text
from slider.reports.figures import ablation as figure
from slider.reports.figures.style import save, style
from slider.reports.rows import (
    Row,
    quality_row,
    read_evaluation,
    reference_gaits,
    table_row,
    with_reference,
    write_rows,
)

TRACKING = ("success_rate", "success_low", "success_high", "mse", "mse_steady", "tracking_rate")
CHECKS = ("success", "speed_error", "flight")
SELECTION = "selection.csv"
NAME = "ablation"


@dataclass(frozen=True)
class Run:
    """One training of a variant: its checks over samples, and a row per evaluated command."""

    variant: str
    seed: int
    curve: dict[str, np.ndarray]
    rows: list[Row]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME_curves.csv``, ``NAME.md``, ``.svg`` and ``.png``."""
    name, runs = section["name"], _read_runs(section, inputs)
    rows = [row for item in runs for row in item.rows]
    write_rows(rows, tuple(rows[0]), out / f"{name}.csv")
    curves = [row for item in runs for row in _curve_rows(item)]
    write_rows(curves, tuple(curves[0]), out / f"{name}_curves.csv")
    labels = {name: variant["label"] for name, variant in section["variants"].items()}
    text = ablation_text.markdown(name, rows, curves, section["variants"])
    (out / f"{name}.md").write_text(text, encoding="utf-8")
    _draw(rows, curves, labels, out / name)
    job.tracker.log_file(out / f"{name}.csv")
    job.tracker.log_file(out / f"{name}.png")
    return {"runs": len(runs), "variants": len(labels)}


def _read_runs(section: Section, inputs: Inputs) -> list[Run]:
    reference, count = reference_gaits(inputs), len(section["commands"])
    runs = []
    for index, about in enumerate(section["runs"]):
        folders = inputs["evaluations"][index * count : (index + 1) * count]
        curve = read_curve(inputs["walking"][index] / SELECTION, about["batch"])
        rows = []
        for folder in folders:
            controller, command, table = read_evaluation(folder)
            found = with_reference(quality_row(controller, command, table), reference)
            rows.append(_row(about["variant"], about["seed"], command, table, found))
        runs.append(Run(about["variant"], about["seed"], curve, rows))
    return runs


def _row(variant: str, seed: int, command: float, table: records.Records, quality: Row) -> Row:
    tracked = table_row(variant, command, table)
    about: Row = {"variant": variant, "seed": str(seed), "command_velocity": command}
    about |= {name: tracked[name] for name in TRACKING}
    return about | {name: value for name, value in quality.items() if name not in _ABOUT}


_ABOUT = ("controller", "command_velocity")


def read_curve(path: Path, batch: int) -> dict[str, np.ndarray]:
    """Checks of a training over its samples; without survivors there is no error and no flight."""
    header, *lines = path.read_text().splitlines()
    values = np.array([[float(text or "nan") for text in line.split(",")] for line in lines])
    table = dict(zip(header.split(","), values.T, strict=True))
    nothing = np.full(len(values), np.nan)
    curve = {name: table.get(name, nothing) for name in CHECKS}
    return {"samples": table["iteration"] * batch, **curve}


def _curve_rows(item: Run) -> list[Row]:
    columns = zip(*item.curve.values(), strict=True)
    return [
        {"variant": item.variant, "seed": str(item.seed)}
        | {
            name: "" if np.isnan(value) else float(value)
            for name, value in zip(item.curve, values, strict=True)
        }
        for values in columns
    ]


def _draw(rows: Sequence[Row], curves: Sequence[Row], labels: dict[str, str], path: Path) -> None:
    with style():
        drawn = figure.draw(rows, curves, labels)
        for _ in range(2):  # the second time with the sizes of the first
            drawn.draw_without_rendering()
        drawn.set_layout_engine("none")
    for suffix in ("svg", "png"):
        save(drawn, path.with_suffix(f".{suffix}"))
