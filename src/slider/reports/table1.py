"""The stage ``table1``: ours beside the paper's, one row per controller and command."""

from collections.abc import Iterator, Mapping, Sequence
from importlib.resources import files
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation.results import ERRORS, Evaluation
from slider.reports import rows as tables
from slider.reports.comparison import METRICS, comparisons
from slider.reports.quantities import PAPER, quantity, speed_text
from slider.reports.rows import NAN, Row
from slider.reports.table import Cell, Heading, Table, Text, Written, document, escape

COLUMNS = (
    "controller",
    "label",
    "source",
    "speed",
    "success_rate",
    "success_rate_std",
    "success_low",
    "success_high",
    "mse",
    "mse_std",
    "mse_steady",
    "mse_steady_std",
    "tracking_rate",
    "tracking_rate_std",
)
_PAPER_TABLE = "paper_table1.csv"
_PROTOCOL = (
    "{trials} trials (seeds {seed} to {last}) × {robots} robots × {duration:g} s per command, from "
    "rest. "
)
_QUALITY = (
    "Means over surviving robots; – where none survived. Success and velocity error do not show a "
    "limp. `reports/gait_quality.csv` has all digits."
)
_CAPTION = (
    "Best values are bold, errors among controllers whose success is within 1 % of the best; "
    "± is the standard deviation over trials, brackets hold Wilson's 95 % interval of the success "
    "rate. Errors are those of robots that survive. The paper "
    "states one MSE and not whether the start counts: it stands beside both of ours."
)


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write Table 1 as CSV, Markdown and LaTeX, and a table about the quality of the gait."""
    evaluations = tables.evaluations(inputs["evaluations"], section["labels"])
    ours, quality = _measured(evaluations, inputs.get("library", ()))
    rows = ours + paper_rows()
    tables.write(rows, out / "table1.csv", COLUMNS)
    tables.write(quality, out / "gait_quality.csv")
    compared = comparisons(rows)
    text = document("Table 1", [Text(_CAPTION), *compared])
    (out / "table1.md").write_text(text, encoding="utf-8")
    lines = [f"% {escape(_CAPTION)}", "% Needs \\usepackage{booktabs}."]
    lines += [table.latex for table in compared]
    (out / "table1.tex").write_text("\n".join(lines), encoding="utf-8")
    job.tracker.log_file(out / "table1.csv")
    job.tracker.log_metrics(_metrics(ours), 0)
    return {"rows": len(ours)}


def blocks(
    evaluations: Sequence[Evaluation], library: Sequence[Path], protocol: Mapping[str, Any]
) -> Iterator[Written]:
    """On the page: a table per metric, and one per controller about the quality of its gait."""
    ours, quality = _measured(evaluations, library)
    last = protocol["seed"] + protocol["trials"] - 1
    yield Text(_PROTOCOL.format(last=last, **protocol) + _CAPTION)
    yield from comparisons(ours + paper_rows())
    yield Heading("How it walks")
    yield Text(_QUALITY)
    yield from quality_tables(quality)


def table_rows(evaluations: Sequence[Evaluation]) -> list[Row]:
    """Rows of ``table1.csv``: ours, then the paper's."""
    return [tables.table_row(one) for one in evaluations] + paper_rows()


def _measured(
    evaluations: Sequence[Evaluation], library: Sequence[Path]
) -> tuple[list[Row], list[Row]]:
    """Rows of Table 1, and of the quality of the gaits."""
    reference = tables.reference_gaits(library)
    quality = [tables.with_reference(tables.quality_row(one), reference) for one in evaluations]
    return [tables.table_row(one) for one in evaluations], quality


def _metrics(rows: list[Row]) -> dict[str, float]:
    """The whole table as metrics of one run, such as ``success_rate/policy/1.2``."""
    metrics = {
        f"{name}/{row['controller']}/{row['speed']}": row[name] for row in rows for name in METRICS
    }
    return {name: value for name, value in metrics.items() if np.isfinite(value)}


def paper_rows() -> list[Row]:
    """The paper's own Table 1, labelled as the paper's; it states no spread."""
    text = files("slider.reports").joinpath(_PAPER_TABLE).read_text(encoding="utf-8")
    printed = tables.read(StringIO(text))
    return [dict.fromkeys(COLUMNS, NAN) | row | {"source": PAPER} for row in printed]


def _estimated(rows: list[Row]) -> bool:
    """Whether the controller receives anything but the true state."""
    return any(row[name] > 0 for row in rows for name in ERRORS)


def quality_tables(rows: list[Row]) -> Iterator[Table]:
    """A table per controller, quantities down, commands across."""
    for label, mine in tables.by(rows, "label").items():
        heads = ["at a command of [m/s]", *(speed_text(row["speed"]) for row in mine)]
        body = [
            [Cell(quantity(name).heading), *(Cell.of(quantity(name), row[name]) for row in mine)]
            for name in mine[0]
            if name not in (*tables.NAMED, "speed") and (name not in ERRORS or _estimated(mine))
        ]
        yield Table(heads, body, label)
