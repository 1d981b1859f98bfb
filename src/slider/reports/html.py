"""Markdown as HTML that needs no other file: pictures and films are in it."""

import base64
import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markdown_it import MarkdownIt
from markdown_it.token import Token
from markupsafe import escape

from slider.reports.video import FILM, POSTER

_CELLS = ("th_open", "td_open")
# Such as ``**0.1 ± 0.2**``, and what stands for none; a number with a word is none.
_NUMBER = re.compile(r"\W*([\d∞](?!.*[^\W\d]{3}).*)?")


def page(title: str, sections: Mapping[str, tuple[str, str]]) -> str:
    """The whole page, without scripts; of each section title and HTML, by its name."""
    environment = Environment(
        loader=PackageLoader("slider.reports", "templates"),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html").render(title=title, sections=sections)


def html(markdown: str, files: Mapping[str, Path]) -> str:
    """Markdown below a section's heading; ``files`` are its pictures and films by their names."""
    parser = MarkdownIt("commonmark", {"html": False}).enable("table")
    parser.add_render_rule("image", _image)
    parser.add_render_rule("table_open", _table)
    parser.add_render_rule("table_close", lambda *_: "</table></div>\n")
    tokens, opened = parser.parse(markdown), 0
    for index, token in enumerate(tokens):
        if token.type.startswith("heading"):
            token.tag = f"h{max(3, int(token.tag[1]) + 1)}"
        elif token.type == "paragraph_open":
            kinds = {child.type for child in tokens[index + 1].children or ()}
            if "image" in kinds <= {"image", "softbreak"}:
                token.tag = tokens[index + 2].tag = "div"
                token.attrSet("class", "pictures")
        elif token.type == "table_open":
            opened = index
        elif token.type == "table_close":
            _align(tokens[opened:index])
    return parser.renderer.render(tokens, parser.options, {"files": files})


def _align(tokens: Sequence[Token]) -> None:
    """Mark the cells of columns that have numbers alone, and a table that is mostly of these."""
    cells = [(token, text.content) for token, text in pairwise(tokens) if token.type in _CELLS]
    width = sum(token.type == "th_open" for token, _ in cells)
    marked = 0
    for column in range(width):
        mine = cells[column::width]
        if all(_NUMBER.fullmatch(text) for _, text in mine[1:]):
            marked += 1
            for token, _ in mine:
                token.attrSet("class", "number")
    if 2 * marked >= width:
        tokens[0].attrSet("class", "numbers")


def _table(self, tokens: Sequence[Token], index: int, options, env) -> str:
    return '<div class="scroll">' + self.renderToken(tokens, index, options, env)


def _image(self, tokens: Sequence[Token], index: int, options, env) -> str:
    """A picture, or a film with its text below; the title of a film is an attribute."""
    token = tokens[index]
    path, text = env["files"][token.attrs["src"]], escape(token.content)
    if path.name != FILM:
        return f'<img src="{data_address(path, "image/svg+xml")}" alt="{text}">'
    poster = data_address(path.with_name(POSTER), "image/jpeg")
    film = f'controls muted loop playsinline {token.attrs.get("title", "")} preload="metadata"'
    film += f' poster="{poster}" src="{data_address(path, "video/mp4")}"'
    return f"<figure><video {film}></video><figcaption>{text}</figcaption></figure>"


def data_address(path: Path, kind: str) -> str:
    """A file as a ``data:`` address of a media type."""
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"
