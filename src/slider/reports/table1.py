"""The stage ``table1``: our results and the paper's, one row per controller and command."""

import math
from collections.abc import Iterator
from functools import partial
from importlib.resources import files
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from slider.config.control import POLICY
from slider.core import tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.core.quantities import decimals, speed_text
from slider.core.tables import Table, escape
from slider.env.metrics import ERRORS
from slider.reports import report
from slider.reports.figures.style import write_pictures
from slider.reports.figures.walking import draw_tradeoff
from slider.reports.quantities import PAPER, PAPER_ROBOT, QUANTITIES
from slider.reports.report import NAMED, across

COLUMNS = (
    *("controller", "label", "source", "speed"),
    *("success_rate", "success_rate_std", "success_low", "success_high"),
    *(name + end for name in ("mse", "mse_steady", "tracking_rate") for end in ("", "_std")),
)
METRICS = {"success_rate": "success_rate", "mse_steady": "mse", "mse": "mse", "tracking_rate": ""}
"""Column of the table → that of the paper's rows.

The paper does not say whether its MSE includes the start: it is compared with both of ours.
"""
TRADEOFF = "tradeoff"
_COMPARABLE = 0.01  # an error is best only where the success rate is this near to the best
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
_SEED = " The policy is of one training; the target `reports/seeds.csv` has the range over seeds."
_LITERAL = " The target `reports/baselines.csv` has the MPC with its literal settings."
_PAPERS = (
    " The paper states one MSE and not whether the start counts: it stands beside both of ours."
)


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write Table 1 in three formats, its figure, and a table about the quality of the gait."""
    robot, caption = section["robot"], _CAPTION
    evaluations = report.load(inputs["evaluations"], section["labels"])
    ours = report.results(evaluations, inputs.get("library", ()))
    if robot == PAPER_ROBOT:
        caption += _PAPERS
    if POLICY in set(ours["controller"]):
        caption += _SEED
    caption += _LITERAL
    rows = ours if robot != PAPER_ROBOT else pd.concat([ours, paper_rows()], ignore_index=True)
    compared = comparisons(rows)
    report.write(out / "table1", "Table 1", robot, rows[[*COLUMNS]], [caption, *compared])
    quality = ours[[name for name in ours if name in {*NAMED, "speed"} or name not in COLUMNS]]
    parts = [_QUALITY, *quality_tables(quality)]
    report.write(out / "gait_quality", "How it walks", robot, quality, parts)
    write_pictures(out / TRADEOFF, partial(draw_tradeoff, ours))
    lines = [f"% Robot: {robot}. {escape(caption)}", "% Needs \\usepackage{booktabs}."]
    lines += [table.latex for table in compared]
    (out / "table1.tex").write_text("\n".join(lines), encoding="utf-8")
    metrics = {
        f"{name}/{one['controller']}/{one['speed']}": one[name]
        for one in ours.to_dict("records")
        for name in METRICS
        if math.isfinite(one[name])
    }
    job.log_metrics(metrics, 0)
    return {"rows": len(ours)}


def paper_rows() -> pd.DataFrame:
    """The paper's own Table 1, labelled as the paper's; it states no spread."""
    text = files("slider.reports").joinpath(_PAPER_TABLE).read_text(encoding="utf-8")
    return tables.read(StringIO(text)).assign(source=PAPER).reindex(columns=COLUMNS)


def quality_tables(frame: pd.DataFrame) -> Iterator[Table]:
    """A table per controller, quantities down, commands across.

    Errors of the estimate are left out for a controller that receives the true state.
    """
    for label, mine in frame.groupby("label", sort=False):
        errors = [name for name in ERRORS if name in mine]
        hidden = {*NAMED, "speed", *(() if (mine[errors] > 0).any(axis=None) else errors)}
        names = [name for name in mine if name not in hidden]
        yield across(str(label), "at a command of [m/s]", "speed", names, mine, form=speed_text)


def comparisons(frame: pd.DataFrame) -> list[Table]:
    """Tables of all metrics, from rows like those of ``table1.csv``."""
    return [compare(frame, name) for name in METRICS]


def compare(frame: pd.DataFrame, name: str) -> Table:
    """One metric; measured controllers first, in the order of the rows.

    The best of a line and all that print alike are marked, unless that is the entire line.
    """
    printed = frame["source"] == PAPER
    theirs = frame[METRICS[name]] if METRICS[name] else np.nan
    frame = frame.assign(value=frame[name].where(~printed, theirs), std=frame[f"{name}_std"])
    speeds = np.sort(frame.loc[~printed, "speed"].unique())
    labels = (frame if METRICS[name] else frame[~printed])["label"].unique()
    lines = (frame[frame["speed"] == speed].set_index("label").reindex(labels) for speed in speeds)
    body = [[speed_text(v), *_marked(line, name)] for v, line in zip(speeds, lines, strict=True)]
    shown = QUANTITIES[name]
    title = shown.title if shown.share else shown.heading
    return Table(["command [m/s]", *labels], body, title)


def _marked(line: pd.DataFrame, name: str) -> list[str]:
    """Mark the best values. Errors are those of survivors: one is best only among controllers that
    lose hardly more robots than the one that loses least.
    """
    share, success = QUANTITIES[name].share, line["success_rate"].fillna(0.0)
    fair = line["value"].notna() & (share | (success >= success.max() - _COMPARABLE))
    values = line["value"][fair]
    best = values.max() if share else values.min()
    cells = [_cell(row, name) for row in line.to_dict("records")]
    digits = 3 if share or not math.isfinite(best) else decimals(best)
    marks = fair & (line["value"].round(digits) == round(best, digits)) & math.isfinite(best)
    if marks.all():
        return cells
    return [f"**{cell}**" if mark else cell for cell, mark in zip(cells, marks, strict=True)]


def _cell(row: dict[str, Any], name: str) -> str:
    """Such as ``99.6 % ± 0.5 [99.0, 99.8]`` or ``0.00837 ± 0.00003``."""
    value, spread = row["value"], row["std"]
    if not math.isfinite(value):
        return QUANTITIES[name].text(value)
    scale, digits, unit = (100, 1, " %") if QUANTITIES[name].share else (1, decimals(value), "")
    text = f"{scale * value:.{digits}f}{unit}"
    if not math.isnan(spread):
        text += f" ± {scale * spread:.{digits}f}"
    if name == "success_rate" and not math.isnan(row["success_low"]):
        text += f" [{100 * row['success_low']:.1f}, {100 * row['success_high']:.1f}]"
    return text
