"""What code a stage really imports: its modules within a package, and third-party packages.

Found statically, on the syntax tree, so that no stage has to be imported to learn its recipe.
"""

import ast
import hashlib
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from slider.core.errors import UserError

_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")  # where the syntax has statements


@dataclass(frozen=True)
class Closure:
    """Modules that an entry module imports, directly or not, and third-party packages.

    ``parts`` are the digests behind ``digest``: of each module, then of each data file.
    """

    modules: tuple[str, ...]
    third_party: tuple[str, ...]
    parts: Mapping[str, str]

    @property
    def digest(self) -> str:
        """The source digest."""
        return digest_parts(self.parts)


@dataclass(frozen=True)
class _Module:
    digest: str
    imports: tuple[str, ...]


def digest_parts(parts: Mapping[str, str]) -> str:
    """Digest of names and their digests, in this order."""
    lines = "".join(f"{name} {digest}\n" for name, digest in parts.items())
    return hashlib.sha256(lines.encode()).hexdigest()


def closure(entry: str, root: Path) -> Closure:
    """Follow the imports of module ``entry`` within its own package below folder ``root``.

    The digest covers the syntax trees without docstrings, those of fields too (comments are not
    part of them), and the data files that lie beside the modules.

    Raises:
        UserError: the entry module does not exist or a module does not parse.
    """
    package = entry.partition(".")[0]
    if _find(root, entry) is None:
        raise UserError(f"expected the stage's module {entry} below {root}, found none")
    found: dict[str, str] = {}
    third_party: set[str] = set()
    waiting, seen = [entry], set[str]()
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        seen.add(name)
        path = _find(root, name)
        if path is None:  # a function or class, not a module
            continue
        module = _read(path, name)
        found[name] = module.digest
        waiting += _parents(name)
        for target in module.imports:
            if target.partition(".")[0] == package:
                waiting.append(target)
            else:
                third_party.add(target.partition(".")[0])
    return _summarise(found, third_party, root)


def _summarise(found: dict[str, str], third_party: set[str], root: Path) -> Closure:
    parts = {name: found[name] for name in sorted(found)}
    folders = {_folder(root, name) for name in found}
    for path in sorted(data for folder in folders for data in _data_files(folder)):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        parts[path.relative_to(root).as_posix()] = content
    packages = sorted(third_party - sys.stdlib_module_names)
    return Closure(tuple(sorted(found)), tuple(packages), parts)


def _find(root: Path, name: str) -> Path | None:
    stem = root.joinpath(*name.split("."))
    for path in (stem.with_name(stem.name + ".py"), stem / "__init__.py"):
        if path.is_file():
            return path
    return None


def _parents(name: str) -> list[str]:
    """Packages on the way: importing a.b.c runs the __init__ files of a and a.b."""
    parts = name.split(".")
    return [".".join(parts[:end]) for end in range(1, len(parts))]


def _folder(root: Path, name: str) -> Path:
    path = _find(root, name)
    assert path is not None
    return path.parent


def _data_files(folder: Path) -> Iterator[Path]:
    """Files that are not Python, here and in sub-folders that are no packages."""
    for path in folder.iterdir():
        if path.is_dir() and path.name != "__pycache__" and not any(path.glob("*.py")):
            yield from _data_files(path)
        elif path.is_file() and not _is_no_data(path.name):
            yield path


def _is_no_data(name: str) -> bool:
    """Python, its marker of types, and what editors leave beside a file while it is open."""
    endings = (".py", ".pyc", ".typed", "~", ".bak", ".orig", ".rej", ".tmp")
    return name.endswith(endings) or name.startswith((".", "#"))


def _read(path: Path, name: str) -> _Module:
    return _analyse(path.read_bytes(), name, path.name == "__init__.py")


@lru_cache(maxsize=4096)
def _analyse(content: bytes, name: str, is_package: bool) -> _Module:
    try:
        tree = ast.parse(content)
    except SyntaxError as error:
        raise UserError(f"module {name}, line {error.lineno}: {error.msg}") from None
    imports = tuple(sorted(set(_imports(tree, name, is_package))))
    _strip_docstrings(tree)
    return _Module(hashlib.sha256(ast.dump(tree).encode()).hexdigest(), imports)


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
    if node.level == 0:
        return node.module or ""
    parts = name.split(".")
    here = parts if is_package else parts[:-1]
    anchor = here[: len(here) - (node.level - 1)]
    return ".".join([*anchor, *([node.module] if node.module else [])])


def _strip_docstrings(tree: ast.Module) -> None:
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    for node in _statements(tree):
        if isinstance(node, documented):
            node.body = [item for item in node.body if not _is_text(item)]


def _is_text(node: ast.stmt) -> bool:
    """A string by itself: a docstring, or what a class says under a field."""
    value = node.value if isinstance(node, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)
