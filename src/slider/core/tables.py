"""Frames in CSV files, tables of texts in Markdown and LaTeX, and documents of these.

A frame has a column for each quantity, in SI units, NaN where there is none; see
:class:`slider.core.quantities.Quantity` for how its numbers are printed.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import IO, NamedTuple

import pandas as pd

from slider.core.errors import require


def write(frame: pd.DataFrame, path: Path, digits: int = 6) -> None:
    """Write CSV without the index; flags become 0 and 1."""
    flags = dict.fromkeys(frame.select_dtypes(bool), int)
    form = f"%.{digits}g"
    frame.astype(flags).to_csv(path, index=False, float_format=form, lineterminator="\n")


def read(
    file: Path | IO[str], expected: Sequence[str] = (), flags: Sequence[str] = ()
) -> pd.DataFrame:
    """Read a file back: numbers, NaN for empty cells, texts, and columns ``flags`` as bool.

    Raises:
        UserError: the file has other columns than ``expected``, if any are.
    """
    frame = pd.read_csv(file, keep_default_na=False, na_values=[""], float_precision="round_trip")
    possible = not expected or [*expected] == [*frame]
    require(possible, str(file), f"the columns {','.join(expected)}", ",".join(frame))
    return frame.astype(dict.fromkeys(flags, bool))


def markdown(parts: Iterable["str | Table"]) -> str:
    """Texts and tables below each other."""
    texts = (part.markdown if isinstance(part, Table) else part for part in parts)
    return "\n\n".join(text.strip("\n") for text in texts) + "\n"


class Table(NamedTuple):
    """Cells are Markdown; a bold one is bold in every format."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""

    @property
    def markdown(self) -> str:
        """The caption as a heading, and the table."""
        texts = [[text.replace("|", "\\|") for text in line] for line in (self.columns, *self.rows)]
        head, *body = (f"| {' | '.join(line)} |" for line in texts)
        lines = [head, "|" + "---|" * len(self.columns), *body]
        return "\n".join([f"## {self.caption}\n"] * bool(self.caption) + lines)

    @property
    def latex(self) -> str:
        r"""A ``tabular`` for ``\input`` below its caption; needs the package booktabs."""
        cells = [list(map(_latex, line)) for line in (self.columns, *self.rows)]
        form = "l" + "r" * (len(self.columns) - 1)
        table = pd.DataFrame(cells[1:], columns=cells[0])
        text = table.to_latex(index=False, column_format=form, escape=False)
        return "\n".join([f"{escape(self.caption)}\n"] * bool(self.caption) + [text])


def _latex(cell: str) -> str:
    text = cell.strip("*")
    return escape(text) if text == cell else f"\\textbf{{{escape(text)}}}"


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
