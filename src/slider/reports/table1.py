"""The stage ``table1``: ours beside the paper's, one row per controller and command."""

import math
from collections.abc import Iterator, Sequence
from importlib.resources import files
from io import StringIO
from pathlib import Path

import numpy as np

from slider.core.job import Inputs, Job, Section, Summary
from slider.core.tables import Table, escape
from slider.evaluation.results import ERRORS, Evaluation
from slider.reports import rows as tables
from slider.reports.document import write_document
from slider.reports.quantities import (
    NONE,
    PAPER,
    PAPER_ROBOT,
    QUANTITIES,
    decimals,
    quantity,
    speed_text,
)
from slider.reports.rows import NAN, Row

COLUMNS = (
    *("controller", "label", "source", "speed"),
    *("success_rate", "success_rate_std", "success_low", "success_high"),
    *(name + end for name in ("mse", "mse_steady", "tracking_rate") for end in ("", "_std")),
)
METRICS = {"success_rate": "success_rate", "mse_steady": "mse", "mse": "mse", "tracking_rate": ""}
"""Column of the table → that of the paper's rows.

The paper does not say whether its MSE has the start in it: it stands beside both of ours.
"""
_COMPARABLE = 0.01  # an error is best only where as many survive as in the best, up to this share
_PAPER_TABLE = "paper_table1.csv"
_QUALITY = (
    "Means over surviving robots; – where none survived. Success and velocity error do not show a "
    "limp. `gait_quality.csv` has all digits."
)
_CAPTION = (
    "Best values are bold, errors among controllers whose success is within 1 % of the best; "
    "± is the standard deviation over trials, brackets hold Wilson's 95 % interval of the success "
    "rate. Errors are those of robots that survive."
)
_LITERAL = (
    " The target `reports/baselines.csv` has the MPC with the settings of the lab's public code."
)
_PAPERS = (
    " The paper states one MSE and not whether the start counts: it stands beside both of ours."
)


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write Table 1 as CSV, Markdown and LaTeX, and a table about the quality of the gait."""
    evaluations = tables.evaluations(inputs["evaluations"], section["labels"])
    rows = table_rows(evaluations, section["robot"])
    tables.write(rows, out / "table1.csv", COLUMNS)
    quality = _quality_rows(evaluations, inputs.get("library", ()))
    tables.write(quality, out / "gait_quality.csv")
    compared, robot, caption = comparisons(rows), section["robot"], _CAPTION
    if robot == PAPER_ROBOT:
        caption += _PAPERS
    if not any(one.controller == "mpc_wbc_literal" for one in evaluations):
        caption += _LITERAL
    parts = [caption, *(table.markdown for table in compared)]
    write_document(out / "table1.md", "Table 1", robot, parts)
    parts = [_QUALITY, *(table.markdown for table in quality_tables(quality))]
    write_document(out / "gait_quality.md", "How it walks", robot, parts)
    lines = [f"% Robot: {robot}. {escape(caption)}", "% Needs \\usepackage{booktabs}."]
    lines += [table.latex for table in compared]
    (out / "table1.tex").write_text("\n".join(lines), encoding="utf-8")
    ours = rows[: len(evaluations)]
    metrics = {
        f"{name}/{one['controller']}/{one['speed']}": one[name] for one in ours for name in METRICS
    }
    job.log_metrics({k: value for k, value in metrics.items() if np.isfinite(value)}, 0)
    return {"rows": len(ours)}


def table_rows(evaluations: Sequence[Evaluation], robot: str) -> list[Row]:
    """Rows of ``table1.csv``: ours, then the paper's where ``robot`` names the paper's robot."""
    rows = [tables.table_row(one) for one in evaluations]
    return rows + (paper_rows() if robot == PAPER_ROBOT else [])


def _quality_rows(evaluations: Sequence[Evaluation], library: Sequence[Path]) -> list[Row]:
    reference = tables.reference_gaits(library)
    return [tables.quality_row(one, reference) for one in evaluations]


def paper_rows() -> list[Row]:
    """The paper's own Table 1, labelled as the paper's; it states no spread."""
    text = files("slider.reports").joinpath(_PAPER_TABLE).read_text(encoding="utf-8")
    printed = tables.read(StringIO(text))
    return [dict.fromkeys(COLUMNS, NAN) | row | {"source": PAPER} for row in printed]


def quality_tables(rows: list[Row]) -> Iterator[Table]:
    """A table per controller, quantities down, commands across.

    Errors of the estimate are left out of a controller that receives the true state.
    """
    for label, mine in tables.by(rows, "label").items():
        hidden = {*tables.NAMED, "speed"}
        if not any(row.get(name, 0.0) > 0 for row in mine for name in ERRORS):
            hidden |= set(ERRORS)
        heads = ["at a command of [m/s]", *(speed_text(row["speed"]) for row in mine)]
        body = [
            [quantity(name).heading, *(quantity(name).text(row[name]) for row in mine)]
            for name in mine[0]
            if name not in hidden
        ]
        yield Table(heads, body, label)


def comparisons(rows: Sequence[Row]) -> list[Table]:
    """All metrics of rows as those of ``table1.csv``."""
    return [compare(rows, name) for name in METRICS]


def compare(rows: Sequence[Row], name: str) -> Table:
    """One metric; measured controllers first, in the order of the rows.

    The best of a line are marked, and all that look the same when printed.
    """
    cells = {(row["source"], row["controller"], row["speed"]): row for row in rows}
    controllers = list(dict.fromkeys((source, controller) for source, controller, _ in cells))
    if not METRICS[name]:
        controllers = [item for item in controllers if item[0] != PAPER]
    commands = sorted({command for source, _, command in cells if source != PAPER})
    body = [
        [speed_text(v), *_marked([cells.get((*one, v)) for one in controllers], name)]
        for v in commands
    ]
    names = {(row["source"], row["controller"]): row["label"] for row in rows}
    heads = ["command [m/s]", *(names[one] for one in controllers)]
    quantity = QUANTITIES[name]
    return Table(heads, body, quantity.title if quantity.share else quantity.heading)


def _marked(rows: Sequence[Row | None], name: str) -> list[str]:
    """Errors are those of robots that survived: one is best only among controllers that hardly
    lose more robots than any.
    """
    share = QUANTITIES[name].share
    success = np.nan_to_num([row["success_rate"] if row else 0.0 for row in rows])
    columns = {PAPER: METRICS[name]}
    values = [row[columns.get(row["source"], name)] if row else math.nan for row in rows]
    fair = ~np.isnan(values) & (share | (success >= success.max() - _COMPARABLE))
    best = (max if share else min)(np.array(values)[fair].tolist(), default=math.nan)
    cells = [_cell(row, value, name) for row, value in zip(rows, values, strict=True)]
    if len(rows) == 1 or not math.isfinite(best):
        return cells
    digits = 3 if share else decimals(best)
    best = round(best, digits)
    return [
        f"**{cell}**" if one and round(value, digits) == best else cell
        for cell, value, one in zip(cells, values, fair, strict=True)
    ]


def _cell(row: Row | None, value: float, name: str) -> str:
    """Such as ``99.6 % ± 0.5 [99.0, 99.8]`` or ``0.00837 ± 0.00003``."""
    if row is None or math.isnan(value):
        return NONE
    if math.isinf(value):
        return "∞"
    share = QUANTITIES[name].share
    spread = math.nan if row["source"] == PAPER else row[f"{name}_std"]
    scale, digits, unit = (100, 1, " %") if share else (1, decimals(value), "")
    text = f"{scale * value:.{digits}f}{unit}"
    if not math.isnan(spread):
        text += f" ± {scale * spread:.{digits}f}"
    if name == "success_rate" and not math.isnan(row["success_low"]):
        text += f" [{100 * row['success_low']:.1f}, {100 * row['success_high']:.1f}]"
    return text
