"""Reports of the protocols beside that of Table 1: a table, its explanation and a figure each."""

from collections.abc import Callable, Iterable
from pathlib import Path

from matplotlib.figure import Figure

from slider.core.job import Job
from slider.reports import rows
from slider.reports.figures.style import write_pictures
from slider.reports.table import Written, document


def write(
    stem: Path,
    title: str,
    found: list[rows.Row],
    draw: Callable[[], Figure],
    blocks: Iterable[Written],
    job: Job,
) -> None:
    """Write ``stem``.csv, .svg, .png and .md."""
    rows.write(found, stem.with_suffix(".csv"))
    write_pictures(stem, draw)
    text = document(f"{title}: {stem.name}", blocks)
    stem.with_suffix(".md").write_text(text, encoding="utf-8")
    job.tracker.log_file(stem.with_suffix(".png"))
