"""What the syntax of one module says: what it does, without its comments, and what it imports."""

import ast
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import resolve_name

from slider.core.errors import UserError

_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")  # where the syntax has statements


@dataclass(frozen=True)
class Module:
    """Digest of a syntax tree without docstrings, and imported names, submodules or not."""

    digest: str
    imports: tuple[str, ...]


def analyse(content: bytes, name: str, is_package: bool) -> Module:
    """Parse a module.

    Raises:
        UserError: it does not parse.
    """
    try:
        tree = ast.parse(content)
    except SyntaxError as error:
        raise UserError(f"module {name}, line {error.lineno}: {error.msg}") from None
    imports = tuple(sorted(set(_imports(tree, name, is_package))))
    _strip_docstrings(tree)
    return Module(hashlib.sha256(ast.dump(tree).encode()).hexdigest(), imports)


def _statements(tree: ast.Module) -> Iterator[ast.AST]:
    """The module and all its statements. Expressions, most of a tree, hold none."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        for field in _BLOCKS:
            waiting += getattr(node, field, ())


def _imports(tree: ast.Module, name: str, is_package: bool) -> Iterator[str]:
    for node in _statements(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = _base(node, name, is_package)
            yield base
            # An imported name may be a submodule; _find tells.
            yield from (f"{base}.{alias.name}" for alias in node.names)


def _base(node: ast.ImportFrom, name: str, is_package: bool) -> str:
    package = name if is_package else name.rpartition(".")[0]
    return resolve_name("." * node.level + (node.module or ""), package)


def _strip_docstrings(tree: ast.Module) -> None:
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    for node in _statements(tree):
        if isinstance(node, documented):
            node.body = [item for item in node.body if not _is_text(item)]


def _is_text(node: ast.stmt) -> bool:
    """A string by itself: a docstring, or what a class says under a field."""
    value = node.value if isinstance(node, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)
