"""A figure's files: SVG, PNG, and its caption in Markdown."""

from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from slider.reports.figures.style import save, style

_DIGITS = 5  # of places, in shares of the figure


def write_figure(stem: Path, title: str, draw: Callable[[], Figure], caption: str) -> None:
    """Write ``stem``.svg, .png and .md; ``draw`` is called in the common style."""
    write_pictures(stem, draw)
    text = f"# {title}\n\n![{title}]({stem.name}.png)\n\n{caption}"
    stem.with_name(f"{stem.name}.md").write_text(text)


def write_pictures(stem: Path, draw: Callable[[], Figure]) -> None:
    """Write ``stem``.svg and .png; ``draw`` is called in the common style."""
    with style():
        figure = draw()
        figure.draw_without_rendering()  # lay it out once, for both files
        figure.set_layout_engine("none")
        _round_layout(figure)
        for suffix in ("svg", "png"):
            save(figure, stem.with_name(f"{stem.name}.{suffix}"))


def _round_layout(figure: Figure) -> None:
    """The layout's solver leaves rounding errors that differ from run to run; files must not."""
    for axes in figure.axes:
        left, bottom, width, height = axes.get_position(original=True).bounds
        axes.set_position((_round(left), _round(bottom), _round(width), _round(height)))
    for text in figure.texts:
        x, y = text.get_position()
        text.set_position((_round(x), _round(y)))


def _round(value: float) -> float:
    return round(float(value), _DIGITS)
