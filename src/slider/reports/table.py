"""Tables, texts and pictures of documents and of the page; each table in every format."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pandas as pd
from markupsafe import Markup
from markupsafe import escape as escape_html

from slider.reports.quantities import Quantity


@dataclass(frozen=True)
class Cell:
    """Text of a cell, Markdown with ``code`` and **bold**, and the number behind it, if any.

    The ``best`` of a line is bold; one that breaks a bound, ``failed``, is red on the page.
    """

    text: str
    key: float | str = ""
    best: bool = False
    failed: bool = False

    @classmethod
    def of(cls, quantity: Quantity, value: float) -> "Cell":
        """A number as its quantity is written."""
        return cls(quantity.text(value), "" if value != value else value)


@dataclass(frozen=True)
class Table:
    """A table with a heading per column and an optional caption."""

    kind: ClassVar = "table"
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""

    def frame(self, text: Callable[[Cell], str] = lambda cell: cell.text) -> pd.DataFrame:
        """Texts of the cells, by default without marks."""
        rows = [[text(cell) for cell in row] for row in self.rows]
        return pd.DataFrame(rows, columns=list(self.columns), dtype=str)

    @property
    def markdown(self) -> str:
        """Lines without the caption; the best are bold."""
        frame = self.frame(lambda cell: f"**{cell.text}**" if cell.best else cell.text)
        lines = [list(self.columns), *frame.to_numpy().tolist()]
        texts = ["| " + " | ".join(t.replace("|", "\\|") for t in line) + " |" for line in lines]
        return "\n".join([texts[0], "|" + "---|" * len(self.columns), *texts[1:]])

    @property
    def latex(self) -> str:
        r"""A ``tabular`` for ``\input`` below its caption; needs the package booktabs."""
        frame = self.frame(
            lambda cell: f"\\textbf{{{escape(cell.text)}}}" if cell.best else escape(cell.text)
        )
        style = frame.rename(columns=escape).style.hide(axis="index")
        body = style.to_latex(hrules=True, column_format="l" + "r" * (len(self.columns) - 1))
        return f"{escape(self.caption)}\n\n{body}" if self.caption else body

    @property
    def html(self) -> Markup:
        """A ``table`` element; columns with numbers are aligned on the right."""
        frame = self.frame(_html_cell)
        columns = zip(self.columns, zip(*self.rows, strict=True), strict=True) if self.rows else ()
        frame.columns = [_html_heading(*column) for column in columns] or frame.columns
        body = frame.to_html(index=False, escape=False, border=0, justify="left")
        caption = f"<caption>{inline(self.caption)}</caption>" if self.caption else ""
        return Markup(body.replace("<thead>", f"{caption}<thead>", 1))


@dataclass(frozen=True)
class Text:
    """Paragraphs of Markdown with ``code``, **bold** and lists.

    On the page they look like a ``note``, ``best``, ``failed`` or as usual.
    """

    kind: ClassVar = "text"
    markdown: str
    look: str = ""


@dataclass(frozen=True)
class Heading:
    """A heading within a section."""

    kind: ClassVar = "heading"
    text: str

    @property
    def markdown(self) -> str:
        """A heading of the second level."""
        return f"## {self.text}"


@dataclass(frozen=True)
class Picture:
    """A figure, by its SVG file."""

    kind: ClassVar = "picture"
    path: Path
    caption: str = ""

    @property
    def markdown(self) -> str:
        """The file as it is published."""
        return f"![{self.path.stem.capitalize()}](figures/{self.path.name})"


Written = Table | Text | Heading | Picture
"""Blocks of documents and of the page."""


def write_document(path: Path, title: str, robot: str, blocks: Iterable[Written]) -> None:
    """Write a Markdown document about a robot, by its name: blocks below each other."""
    parts = [f"# {title}", f"Robot: {robot}"]
    for block in blocks:
        if isinstance(block, Table) and block.caption:
            parts.append(Heading(block.caption).markdown)
        parts.append(block.markdown.strip("\n"))
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def grid(columns: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> Table:
    """Table of plain texts."""
    return Table(columns, [[Cell(text) for text in row] for row in rows], caption)


def inline(text: str) -> Markup:
    """Markdown within a paragraph, ``code`` and **bold**, as HTML."""
    html = re.sub(r"`([^`]*)`", r"<code>\1</code>", str(escape_html(text)))
    html = re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", html)
    return Markup(html.replace("\\*", "*"))


def escape(text: str) -> str:
    """Text as LaTeX reads it."""
    return "".join(_LATEX.get(character, character) for character in text)


_LATEX = {character: f"\\{character}" for character in "%&#$_{}"} | {
    "±": "$\\pm$",
    "∞": "$\\infty$",
    "²": "$^2$",
    "–": "--",
    "\\": "\\textbackslash{}",
    "~": "\\textasciitilde{}",
    "^": "\\textasciicircum{}",
    "<": "$<$",
    ">": "$>$",
    "|": "$|$",
}


def _html_heading(text: str, cells: Sequence[Cell]) -> str:
    numeric = any(isinstance(cell.key, (int, float)) for cell in cells)
    return f'<span class="number">{inline(text)}</span>' if numeric else str(inline(text))


def _html_cell(cell: Cell) -> str:
    names = {"number": isinstance(cell.key, (int, float)), "best": cell.best, "failed": cell.failed}
    look = " ".join(name for name, given in names.items() if given)
    # Narrow screens hide the spread.
    text = re.sub(r" (±.*|\[.*)$", r" <small>\1</small>", str(inline(cell.text)))
    return f'<span class="{look}">{text}</span>' if look else text
