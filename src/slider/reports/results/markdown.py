"""A table of the page as Markdown."""

from collections.abc import Sequence

from slider.reports.page import Cell, Table


def grid(columns: Sequence[str], rows: Sequence[Sequence[str]], caption: str = "") -> Table:
    """Table of plain texts."""
    return Table(columns, [[Cell(text) for text in row] for row in rows], caption, sortable=False)


def markdown(table: Table) -> str:
    """Lines of a table, its caption above in bold."""
    lines = [_line(table.columns), "|" + "---|" * len(table.columns)]
    lines += [_line([cell.text for cell in row]) for row in table.rows]
    return "\n".join([f"**{table.caption}**", "", *lines] if table.caption else lines)


def _line(texts: Sequence[str]) -> str:
    return "| " + " | ".join(text.replace("|", "\\|") for text in texts) + " |"
