"""Tables of texts: rows of cells below headings, in Markdown and in LaTeX."""

from collections.abc import Sequence
from typing import NamedTuple


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
        head, *body = (
            " & ".join(map(_latex, line)) + r" \\" for line in (self.columns, *self.rows)
        )
        form = "l" + "r" * (len(self.columns) - 1)
        lines = [rf"\begin{{tabular}}{{{form}}}", r"\toprule", head, r"\midrule"]
        lines += [*body, r"\bottomrule", r"\end{tabular}", ""]
        return "\n".join([f"{escape(self.caption)}\n"] * bool(self.caption) + lines)


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
