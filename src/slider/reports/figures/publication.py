"""A figure's files: SVG, PNG, and its caption in Markdown."""

from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from slider.reports.figures.style import save, style


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
        for suffix in ("svg", "png"):
            save(figure, stem.with_name(f"{stem.name}.{suffix}"))
