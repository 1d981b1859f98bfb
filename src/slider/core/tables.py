"""Data frames in CSV files, text tables in Markdown and LaTeX, and documents made of tables.

A frame has one column per quantity, in SI units, with NaN for missing values; see
:class:`slider.core.quantities.Quantity` for number formats.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import IO, NamedTuple

import pandas as pd

from slider.core.errors import require


def write(frame: pd.DataFrame, path: Path, digits: int = 6) -> None:
    """Write CSV without the index; booleans become 0 and 1."""
    flags = dict.fromkeys(frame.select_dtypes(bool), int)
    form = f"%.{digits}g"
    frame.astype(flags).to_csv(path, index=False, float_format=form, lineterminator="\n")


def read(
    file: Path | IO[str], expected: Sequence[str] = (), flags: Sequence[str] = ()
) -> pd.DataFrame:
    """Read a CSV file: numbers, texts, NaN for empty cells, and columns ``flags`` as bool.

    Raises:
        UserError: ``expected`` is given and differs from the columns of the file.
    """
    frame = pd.read_csv(file, keep_default_na=False, na_values=[""], float_precision="round_trip")
    possible = not expected or [*expected] == [*frame]
    require(possible, str(file), f"the columns {','.join(expected)}", ",".join(frame))
    return frame.astype(dict.fromkeys(flags, bool))


def markdown(parts: Iterable["str | Table"]) -> str:
    """Markdown document of texts and tables."""
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
    """Text with LaTeX's special characters escaped."""
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
