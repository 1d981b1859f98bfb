"""What documents and the page are made of: tables, texts and pictures, here as Markdown."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from slider.reports.quantities import Quantity


@dataclass(frozen=True)
class Cell:
    """A cell of a table: what is shown, what it is sorted by, and whether none is better."""

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
    """A table, on the page by default one that sorts by a click on a heading."""

    kind: ClassVar = "table"
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    sortable: bool = True

    @property
    def headings(self) -> list[tuple[str, bool]]:
        """Each column's heading, and whether numbers stand below it."""
        return [
            (column, any(isinstance(row[index].key, (int, float)) for row in self.rows))
            for index, column in enumerate(self.columns)
        ]

    @property
    def markdown(self) -> str:
        """Lines without the caption; the best are bold."""
        lines = [_line(self.columns), "|" + "---|" * len(self.columns)]
        lines += [_line([_marked(cell, "**{}**") for cell in row]) for row in self.rows]
        return "\n".join(lines)

    @property
    def latex(self) -> str:
        r"""A ``tabular`` for ``\input``; needs the package booktabs."""
        columns = "l" + "r" * (len(self.columns) - 1)
        lines = [
            f"\\begin{{tabular}}{{{columns}}}",
            "\\toprule",
            f"\\multicolumn{{{len(columns)}}}{{l}}{{{escape(self.caption)}}} \\\\",
            "\\midrule",
            " & ".join(map(escape, self.columns)) + " \\\\",
            "\\midrule",
        ]
        for row in self.rows:
            cells = [f"\\textbf{{{escape(c.text)}}}" if c.best else escape(c.text) for c in row]
            lines.append(" & ".join(cells) + " \\\\")
        return "\n".join([*lines, "\\bottomrule", "\\end{tabular}", ""])


@dataclass(frozen=True)
class Tables:
    """Tables next to each other, where there is room."""

    kind: ClassVar = "tables"
    tables: Sequence[Table]


@dataclass(frozen=True)
class Text:
    """Paragraphs of Markdown with ``code``, **bold** and lists.

    On the page they look like a ``note``, ``best``, ``failed`` or as usual.
    """

    kind: ClassVar = "text"
    markdown: str
    look: str = ""

    @property
    def paragraphs(self) -> list[str]:
        """What blank lines separate."""
        return [part for part in self.markdown.split("\n\n") if part.strip()]


@dataclass(frozen=True)
class Heading:
    """A heading within a section."""

    kind: ClassVar = "heading"
    text: str

    @property
    def markdown(self) -> str:
        """Of the second level."""
        return f"## {self.text}"


@dataclass(frozen=True)
class Picture:
    """A figure of a stage, by its SVG file."""

    kind: ClassVar = "picture"
    path: Path
    caption: str = ""

    @property
    def markdown(self) -> str:
        """The PNG file as it is published."""
        return f"![{self.path.stem.capitalize()}](figures/{self.path.stem}.png)"


Written = Table | Tables | Text | Heading | Picture
"""What can stand in a document as well as on the page."""


def document(title: str, blocks: Iterable[Written]) -> str:
    """A Markdown document."""
    return f"# {title}\n\n{markdown(blocks)}\n"


def markdown(blocks: Iterable[Written], caption: str = "## {}") -> str:
    """Blocks below each other, captions as headings."""
    parts: list[str] = []
    for block in blocks:
        for item in block.tables if isinstance(block, Tables) else [block]:
            if isinstance(item, Table) and item.caption:
                parts.append(caption.format(item.caption))
            parts.append(item.markdown.strip("\n"))
    return "\n\n".join(parts)


def grid(columns: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> Table:
    """Table of plain texts."""
    return Table(columns, [[Cell(text) for text in row] for row in rows], caption, sortable=False)


def listed(texts: Iterable[str]) -> str:
    """Texts as a sentence lists them: with commas, and an "and" before the last one."""
    *first, last = texts
    return f"{', '.join(first)} and {last}" if first else last


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


def _marked(cell: Cell, pattern: str) -> str:
    return pattern.format(cell.text) if cell.best else cell.text


def _line(texts: Iterable[str]) -> str:
    return "| " + " | ".join(text.replace("|", "\\|") for text in texts) + " |"
