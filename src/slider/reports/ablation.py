"""The stage ``ablation``: what each choice of the method is worth, as tables and a figure.

With one variant it is the same about the seeds of the training alone.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation.results import Evaluation
from slider.reports import rows as tables
from slider.reports.controllers import speed
from slider.reports.figures import ablation as figure
from slider.reports.figures.style import write_pictures
from slider.reports.quantities import QUANTITIES, Quantity
from slider.reports.rows import NAN, Row, by, distinct
from slider.reports.table import Cell, Picture, Table, Text, Written, document
from slider.training.results import Training

NAME = "ablation"
LEARNED = 0.95  # share of robots that survive a check of a policy that has learned to walk
METRICS = (
    "success_rate",
    "mse_steady",
    "tracking_rate",
    "alternation",
    "flight",
    "slip",
    "clearance",
    "asymmetry",
    "velocity_variance",
    "cost_of_transport",
)
_TRACKING = ("success_rate", "success_low", "success_high", "mse", "mse_steady", "tracking_rate")
_CHECKS = ("success", "speed_error", "flight")
_SAMPLES = Quantity(f"Samples until {100 * LEARNED:.0f} % of a check's robots survive", "M")
_CAPTION = "Learning curves of the variants above; survival, error and quality of the walk below."
Variants = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True)
class Ablation:
    """Rows of all finished policies, one per variant, seed and command, and of all checks."""

    policies: list[Row]
    checks: list[Row]

    def save(self, folder: Path, name: str) -> None:
        """Write ``NAME.csv`` and ``NAME_curves.csv``."""
        tables.write(self.policies, folder / f"{name}.csv")
        tables.write(self.checks, folder / f"{name}_curves.csv")

    @classmethod
    def load(cls, folder: Path, name: str = NAME) -> "Ablation":
        """Read both files back."""
        return cls(tables.read(folder / f"{name}.csv"), tables.read(folder / f"{name}_curves.csv"))


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME_curves.csv``, ``NAME.md``, ``.svg`` and ``.png``."""
    name, variants, found = section["name"], section["variants"], _collect(section, inputs)
    found.save(out, name)
    labels = {name: variant["label"] for name, variant in variants.items()}
    write_pictures(out / name, lambda: figure.draw(found.policies, found.checks, labels))
    text = document(name.capitalize(), blocks(name, out / f"{name}.svg", found, variants))
    (out / f"{name}.md").write_text(text, encoding="utf-8")
    job.tracker.log_file(out / f"{name}.csv")
    job.tracker.log_file(out / f"{name}.png")
    return {"runs": len(section["runs"]), "variants": len(labels)}


def _collect(section: Section, inputs: Inputs) -> Ablation:
    reference, count = tables.reference_gaits(inputs["library"]), len(section["commands"])
    found = Ablation([], [])
    for index, about in enumerate(section["runs"]):
        named = {"variant": about["variant"], "seed": str(about["seed"])}
        for folder in inputs["evaluations"][index * count : (index + 1) * count]:
            found.policies.append(named | _row(Evaluation.load(folder), reference))
        training = Training.load(inputs["walking"][index])
        found.checks.extend(named | check for check in check_rows(training, about["batch"]))
    return found


def _row(evaluation: Evaluation, reference: tables.Reference) -> Row:
    tracked = tables.table_row(evaluation)
    row = {name: tracked[name] for name in ("command_velocity", *_TRACKING)}
    quality = tables.with_reference(tables.quality_row(evaluation), reference)
    return row | {name: value for name, value in quality.items() if name not in tables.NAMED}


def check_rows(training: Training, batch: int) -> Iterator[Row]:
    """Checks of a training over its samples, ``batch`` per iteration."""
    columns = [training.checks["iteration"] * batch, *(training.checks[n] for n in _CHECKS)]
    for values in zip(*columns, strict=True):
        yield dict(zip(("samples", *_CHECKS), map(float, values), strict=True))


def blocks(name: str, svg: Path, found: Ablation, variants: Variants) -> Iterator[Written]:
    """The figure, the variants, and a table per number: variants down, commands across."""
    seeds = {row["seed"] for row in found.policies}
    over = f"mean of {len(seeds)} seeds (least to greatest)" if len(seeds) > 1 else "one seed"
    yield Text(
        f"Every number: {over}; errors and gait quality are those of surviving robots. Where none "
        "of a seed survived, its error is ∞ and its gait quality is left out. "
        f"`reports/{name}.csv` has them all."
    )
    yield Picture(svg, _CAPTION)
    yield _variants(found.checks, variants)
    for metric in METRICS:
        yield _table(found.policies, metric, variants)


def _variants(checks: Sequence[Row], variants: Variants) -> Table:
    rows = []
    for name, about in variants.items():
        first = first_learned(checks, name)
        changes = " ".join(f"`{text}`" for text in about["overrides"]) or "none"
        mean = _known(first, np.mean)
        learned = Cell(_learned(first), "" if math.isnan(mean) else mean)
        rows.append([Cell(about["label"], about["label"]), learned, Cell(changes)])
    return Table(["variant", _SAMPLES.heading, "overrides"], rows)


def first_learned(checks: Sequence[Row], variant: str) -> list[float]:
    """For each seed millions of samples at which it first passes ``LEARNED``; NaN for never."""
    seeds = by((row for row in checks if row["variant"] == variant), "seed")
    return [
        next((row["samples"] / 1e6 for row in mine if row["success"] >= LEARNED), NAN)
        for mine in seeds.values()
    ]


def _learned(first: Sequence[float]) -> str:
    """When the seeds learned, and how many never did."""
    never = sum(map(math.isnan, first))
    if never == len(first):
        return "never"
    text = spread(_SAMPLES, first).text
    return f"{text}; {never} of {len(first)} never" if never else text


def _table(rows: Sequence[Row], metric: str, variants: Variants) -> Table:
    quantity, commands = QUANTITIES[metric], distinct(rows, "command_velocity")
    groups = by(rows, "variant", "command_velocity")
    body = [
        [Cell(about["label"], about["label"])]
        + [spread(quantity, [row[metric] for row in groups[name, v]]) for v in commands]
        for name, about in variants.items()
    ]
    reference = f"reference_{metric}"
    if reference in rows[0]:
        gaits = {row["command_velocity"]: row[reference] for row in rows}
        body.append([Cell("the library's gait"), *(Cell.of(quantity, gaits[v]) for v in commands)])
    heads = ["variant", *(f"{speed(command)} m/s" for command in commands)]
    return Table(heads, body, quantity.heading)


def spread(
    quantity: Quantity, values: Sequence[float], middle: Callable[..., Any] = np.mean
) -> Cell:
    """Mean, least and greatest of the numbers there are."""
    number = _known(values, middle)
    if math.isnan(number):
        return Cell.of(quantity, number)
    return Cell(quantity.ranged(number, _known(values, np.min), _known(values, np.max)), number)


def _known(values: Sequence[float], number: Callable[..., Any]) -> float:
    """A number of those that are not NaN; NaN where there is none."""
    known = [value for value in values if not math.isnan(value)]
    return float(number(known)) if known else NAN
