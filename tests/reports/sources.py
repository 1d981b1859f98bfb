"""Parts of a document, as a reader finds them."""

from collections.abc import Iterable

from slider.core.tables import Table, markdown


def tables(parts: Iterable[str | Table]) -> dict[str, list[list[str]]]:
    """Headings and rows of each Markdown table, by the heading above it."""
    found, title = {}, ""
    for line in markdown(parts).splitlines():
        if line.startswith("## "):
            title = line.removeprefix("## ")
        if line.startswith("| "):
            cells = line.removeprefix("| ").removesuffix(" |").split(" | ")
            cells = [cell.replace("\\|", "|") for cell in cells]
            found.setdefault(title, []).append(cells)
    return found
