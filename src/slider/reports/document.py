"""Documents: what a report says in Markdown, beside its table; the page is made of them."""

from collections.abc import Iterable
from pathlib import Path

from slider.reports.quantities import PAPER_ROBOT


def picture(name: str) -> str:
    """The figure ``name``.svg as it is published."""
    return f"![{name.capitalize()}](figures/{name}.svg)"


def write_document(path: Path, title: str, robot: str, parts: Iterable[str]) -> None:
    """Write texts, tables and pictures below each other; names a robot that is not the paper's."""
    head = [f"# {title}", *([] if robot == PAPER_ROBOT else [f"Robot: {robot}"])]
    text = "\n\n".join(part.strip("\n") for part in [*head, *parts])
    path.write_text(text + "\n", encoding="utf-8")
