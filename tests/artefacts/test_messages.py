"""Every message about the store is on the page that says what to do."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import slider.artefacts
from slider.artefacts.maintenance import Removed

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "troubleshooting.md"
ABOUT_SOURCES = ("recipe.py", "source.py", "syntax.py")  # for who changes them
DROPPED = [f"dropped {text}" for text in Removed(["…"], ["…"], ["…"], ["…"]).damage]


def messages() -> Iterator[str]:
    """Texts of the errors of the store, with … where they name something."""
    for path in sorted(Path(slider.artefacts.__path__[0]).glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if path.name in ABOUT_SOURCES or not isinstance(node, ast.Call):
                continue
            if isinstance(node.func, ast.Name) and node.func.id == "UserError":
                yield _text(node.args[0])


def _text(node: ast.expr) -> str:
    parts = node.values if isinstance(node, ast.JoinedStr) else [node]
    return "".join(p.value if isinstance(p, ast.Constant) else "…" for p in parts)  # type: ignore


@pytest.mark.parametrize("message", [*messages(), *DROPPED])
def test_the_page_has_the_message(message):
    text = f"`` {message} ``" if "`" in message else f"`{message}`"
    assert f"| {text} |" in PAGE.read_text()
