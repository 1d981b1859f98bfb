"""The stage ``baseline_tuning``: what the searches for settings found, present and best values."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from slider.core.job import Inputs, Job, Section, Summary
from slider.core.tables import Table
from slider.evaluation.tuning import CSV, ERROR, FINALIST, SUCCESS
from slider.reports import rows as tables
from slider.reports.document import picture, write_document
from slider.reports.figures.style import new_figure, write_pictures
from slider.reports.quantities import QUANTITIES, colour, speed_text
from slider.reports.rows import Row

_CAPTION = """\
The score is the mean over the commands v of log10(e / v² + f / 10), with e the mean squared
velocity error of the surviving robots after the warm-up and f the share that falls. Trial 0 is the
present one. The tables show finalists, which have more robots.
"""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write all trials as ``baseline_tuning.csv``, present and best ones as Markdown, a figure."""
    names = [*section["labels"]]
    trials = {
        name: tables.read(folder / CSV)
        for name, folder in zip(names, inputs["searches"], strict=True)
    }
    rows = [{"controller": name} | row for name, mine in trials.items() for row in mine]
    columns = dict.fromkeys(column for row in rows for column in row)
    tables.write(rows, out / "baseline_tuning.csv", list(columns))
    write_pictures(out / "baseline_tuning", partial(_draw, trials, section["labels"]))
    written = [table for name in names for table in _tables(name, trials[name], section)]
    shown = [_CAPTION, picture("baseline_tuning"), *(table.markdown for table in written)]
    write_document(out / "baseline_tuning.md", "Tuned baselines", section["robot"], shown)
    scores = {name: _present_and_best(trials[name])[1]["score"] for name in names}
    return {"trials": len(rows), "scores": scores}


def _of(trials: Sequence[Row], finalist: int) -> list[Row]:
    return [row for row in trials if row[FINALIST] == finalist]


def _present_and_best(trials: Sequence[Row]) -> tuple[Row, Row]:
    finalists = _of(trials, 1)
    return finalists[0], min(finalists, key=lambda row: row["score"])


def _tables(name: str, trials: Sequence[Row], section: Mapping[str, Any]) -> Iterator[Table]:
    """Settings, then success and error at each command, of the present and the best trial."""
    (present, best), label = _present_and_best(trials), section["labels"][name]
    score = f"trial {best['trial']:g} of {len(_of(trials, 0))}, score {best['score']:.3f}"
    heads = [f"control.{name}", "range", f"present, score {present['score']:.3f}", score]
    body = []
    for key, limits in section["spaces"][name].items():
        values = (f"{trial[key]:.3g}" for trial in (present, best))
        body.append([key, f"{limits['lower']:g} to {limits['upper']:g}", *values])
    yield Table(heads, body, label)
    prefix = f"{SUCCESS}_"
    speeds = [column.removeprefix(prefix) for column in best if column.startswith(prefix)]
    lines = []
    for title, row in (("present", present), ("best", best)):
        for key, quantity in ((SUCCESS, "success_rate"), (ERROR, "mse_steady")):
            shown = QUANTITIES[quantity]
            texts = (shown.text(row[f"{key}_{speed}"]) for speed in speeds)
            lines.append([f"{shown.heading}, {title}", *texts])
    yield Table(["command [m/s]", *(speed_text(float(speed)) for speed in speeds)], lines)


def _draw(trials: Mapping[str, Sequence[Row]], labels: Mapping[str, str]) -> Figure:
    """Best score so far, over the trials."""
    figure = new_figure(2.6)
    axes = figure.add_subplot()
    for index, (name, mine) in enumerate(trials.items()):
        best = np.minimum.accumulate([row["score"] for row in _of(mine, 0)])
        axes.step(range(len(best)), best, where="post", color=colour(index), label=labels[name])
    axes.set(xlabel="trial", ylabel="best score so far")
    axes.legend()
    return figure
