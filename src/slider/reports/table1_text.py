"""Table 1 for documents: Markdown and LaTeX."""

import math
from collections.abc import Sequence

from slider.reports.comparison import METRICS, Comparison, Metric, Value, compare, show
from slider.reports.controllers import speed

_CAPTION = (
    "Best values are bold, errors among controllers whose success is within 1 % of the best; "
    "± is the standard deviation over trials, brackets hold Wilson's 95 % interval of the success "
    "rate. Errors are those of robots that survive. The paper "
    "states one MSE and not whether the start counts: it stands beside both of ours."
)


def markdown(rows: Sequence[dict[str, str]]) -> str:
    """One Markdown table per metric, best values bold."""
    tables = [_markdown_table(compare(rows, metric)) for metric in METRICS]
    return "\n".join(["# Table 1", "", _CAPTION, "", *tables])


def _markdown_table(table: Comparison) -> str:
    lines = [
        f"## {table.metric.title}",
        "",
        f"| command [m/s] | {' | '.join(table.controllers)} |",
        f"|---|{'---|' * len(table.controllers)}",
    ]
    for command, row in zip(table.commands, table.rows, strict=True):
        cells = (_bold(value, table.metric, "**{}**") for value in row)
        lines.append(f"| {speed(command)} | {' | '.join(cells)} |")
    return "\n".join([*lines, ""])


def latex(rows: Sequence[dict[str, str]]) -> str:
    r"""One ``tabular`` per metric for ``\input``; needs the package booktabs."""
    tables = [_latex_table(compare(rows, metric)) for metric in METRICS]
    return "\n".join([f"% {_escape(_CAPTION)}", "% Needs \\usepackage{booktabs}.", *tables])


def _latex_table(table: Comparison) -> str:
    columns = "l" + "r" * len(table.controllers)
    title = _escape(table.metric.title)
    lines = [
        f"\\begin{{tabular}}{{{columns}}}",
        "\\toprule",
        f"\\multicolumn{{{len(columns)}}}{{l}}{{{title}}} \\\\",
        "\\midrule",
        " & ".join(["command [m/s]", *map(_escape, table.controllers)]) + " \\\\",
        "\\midrule",
    ]
    for command, row in zip(table.commands, table.rows, strict=True):
        cells = (_escape(_bold(value, table.metric, "@{}@")) for value in row)
        marked = (f"\\textbf{{{cell[1:-1]}}}" if cell[:1] == "@" else cell for cell in cells)
        lines.append(" & ".join([speed(command), *marked]) + " \\\\")
    return "\n".join([*lines, "\\bottomrule", "\\end{tabular}", ""])


def _bold(value: Value | None, metric: Metric, pattern: str) -> str:
    text = show(value, metric)
    best = value is not None and value.best and not math.isinf(value.value)
    return pattern.format(text) if best else text


_LATEX = {"%": "\\%", "±": "$\\pm$", "∞": "$\\infty$", "²": "$^2$", "–": "--", "_": "\\_"}


def _escape(text: str) -> str:
    return "".join(_LATEX.get(character, character) for character in text)
