"""Table 1: ours, the baselines' and the paper's side by side, and how it walks."""

from slider.reports.comparison import METRICS, Comparison, Value, compare, read_rows, show
from slider.reports.controllers import speed
from slider.reports.page import Cell, Section, Table
from slider.reports.sections.quality import quality_tables
from slider.reports.sections.sources import Sources


def section(sources: Sources) -> Section:
    """One table per metric, and one per controller about the quality of its gait."""
    rows = read_rows(sources.file("table1", "table1.csv"))
    tables = [comparison_table(compare(rows, metric)) for metric in METRICS]
    quality = quality_tables(sources.file("table1", "gait_quality.csv"))
    protocol = sources.configuration["evaluation"]
    values = {"tables": tables, "quality": quality, "protocol": protocol}
    return Section("Table 1", "table1.html", values)


def comparison_table(table: Comparison) -> Table:
    """Commands down, controllers across; the best of a row is marked if there are others."""
    rows = [
        [Cell(speed(command), command), *(_cell(value, table) for value in row)]
        for command, row in zip(table.commands, table.rows, strict=True)
    ]
    return Table(["command [m/s]", *table.controllers], rows, table.metric.title)


def _cell(value: Value | None, table: Comparison) -> Cell:
    text = show(value, table.metric)
    if value is None:
        return Cell(text)
    return Cell(text, value.value, value.best and len(table.controllers) > 1)
