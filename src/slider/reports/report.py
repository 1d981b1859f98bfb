"""Shared parts of reports: evaluations as a frame; table, figure and document as files."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pandas.api.types import is_numeric_dtype

from slider.core import tables
from slider.core.quantities import NONE
from slider.core.tables import Table
from slider.evaluation.results import Evaluation, compare
from slider.reports.figures.style import write_pictures
from slider.reports.quantities import OURS, PAPER_ROBOT, quantity

NAMED = ["controller", "label"]


def load(folders: Iterable[Path], labels: Mapping[str, str]) -> list[Evaluation]:
    """Evaluations in folders, each with its controller's label."""
    return [Evaluation.load(folder, labels) for folder in folders]


def results(
    evaluations: Sequence[Evaluation], library: Sequence[Path] | None = None
) -> pd.DataFrame:
    """The rows of :func:`slider.evaluation.results.compare`, with ``label`` and ``source``.

    Without the statistics of the library's gaits where ``library`` is None.
    """
    frame = compare(evaluations, library or ())
    frame.insert(1, "label", [one.label for one in evaluations])
    frame.insert(2, "source", OURS)
    return frame if library is not None else frame.filter(regex="^(?!reference_)")


def across(
    title: str,
    head: str,
    column: str,
    quantities: Sequence[str],
    frame: pd.DataFrame,
    keys: Sequence[str] = (),
    form: Callable[[float], str] = "{:g}".format,
) -> Table:
    """Quantities and the ``keys`` of rows down, the values of a column across.

    Texts as values are shown as they are.
    """
    values, body = np.sort(frame[column].unique()), []
    for name in quantities:
        heading, numbers = quantity(name).heading, is_numeric_dtype(frame[name])
        for key, mine in frame.groupby([*keys], sort=False) if keys else [((), frame)]:
            texts = map(quantity(name).text, mine[name]) if numbers else mine[name]
            cells = dict(zip(mine[column], texts, strict=True))
            body.append([heading, *key, *(cells.get(value, NONE) for value in values)])
            heading = ""
    return Table([head, *[""] * len(keys), *map(form, values)], body, title)


def picture(name: str) -> str:
    """The figure ``name``.svg as it is published."""
    return f"![{name.capitalize()}](figures/{name}.svg)"


def write(
    stem: Path,
    title: str,
    robot: str,
    frame: pd.DataFrame,
    parts: Iterable[str | Table],
    draw: Callable[[], Figure] | None = None,
) -> None:
    """Write ``stem``.csv, .md, and .svg of what is drawn.

    Texts and tables follow the title; a robot other than the paper's is named.
    """
    tables.write(frame, stem.with_suffix(".csv"))
    head = [f"# {title}", *([] if robot == PAPER_ROBOT else [f"Robot: {robot}"])]
    stem.with_suffix(".md").write_text(tables.markdown([*head, *parts]), encoding="utf-8")
    if draw is not None:
        write_pictures(stem, draw)
