"""Markdown as self-contained HTML, with pictures and films embedded."""

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path

from jinja2 import Environment, PackageLoader
from markdown_it import MarkdownIt
from markdown_it.token import Token
from markupsafe import escape

from slider.reports.video import FILM, POSTER

_LONGEST = 40  # characters of a number with its spread and interval, which stay in one line


def page(title: str, sections: Mapping[str, tuple[str, str]]) -> str:
    """The entire page, without scripts; ``sections`` are title and HTML by name."""
    environment = Environment(loader=PackageLoader("slider.reports", "templates"), autoescape=True)
    return environment.get_template("page.html").render(title=title, sections=sections)


def html(markdown: str, files: Mapping[str, Path]) -> str:
    """Markdown below a section's heading; ``files`` are its pictures and films by their names."""
    parser = MarkdownIt("commonmark", {"html": False}).enable("table")
    parser.add_render_rule("image", _image)
    parser.add_render_rule("table_open", _table)
    parser.add_render_rule("table_close", lambda *_: "</table></div>\n")
    tokens = parser.parse(markdown)
    for index, token in enumerate(tokens):
        if token.type.startswith("heading"):
            token.tag = f"h{max(3, int(token.tag[1]) + 1)}"
        elif token.type == "paragraph_open":
            kinds = {child.type for child in tokens[index + 1].children or ()}
            if "image" in kinds <= {"image", "softbreak"}:
                token.tag = tokens[index + 2].tag = "div"
                token.attrSet("class", "pictures")
        elif token.type == "td_open":
            text = tokens[index + 1].content
            if text.lstrip("*")[:1].isdigit() and len(text) < _LONGEST:
                token.attrSet("class", "number")
    return parser.renderer.render(tokens, parser.options, {"files": files})


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
    """``data:`` URL of a file of a media type."""
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"
