"""Modules and packages that a stage imports, and the digests of its source.

They are read from the syntax trees, so that no stage has to be imported to learn its recipe.
"""

import ast
import hashlib
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.util import resolve_name
from os.path import isfile
from pathlib import Path

from slider.core.errors import UserError
from slider.core.files import digest_file, digest_text

_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")  # where the syntax has statements
DATA = (".css", ".csv", ".html", ".js", ".json", ".txt", ".xml", ".yaml")
"""Endings of data files, which a source digest covers where they lie beside its modules."""


@dataclass(frozen=True)
class Module:
    """Digest of a syntax tree without docstrings, and imported names, submodules or not."""

    digest: str
    imports: tuple[str, ...]


def parse(content: bytes, name: str, is_package: bool) -> Module:
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
    """A string by itself: the docstring of a module, class, function or field."""
    value = node.value if isinstance(node, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


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
        """The source digest: of names and their digests, in this order."""
        return digest_text("".join(f"{name} {digest}\n" for name, digest in self.parts.items()))


class Sources:
    """The files below a folder as they were when a closure first came to them."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._files: dict[str, Path | None] = {}
        self._modules: dict[str, Module] = {}
        self._data: dict[Path, dict[str, str]] = {}

    def find(self, name: str) -> Path | None:
        """File of a module; nothing where the name is a function's or a class's."""
        if name not in self._files:
            self._files[name] = _find(self.root, name)
        return self._files[name]

    def module(self, name: str, path: Path) -> Module:
        """Digest and imports of a module.

        Raises:
            UserError: it does not parse.
        """
        if name not in self._modules:
            self._modules[name] = parse(path.read_bytes(), name, path.name == "__init__.py")
        return self._modules[name]

    def data(self, folder: Path) -> dict[str, str]:
        """Digests of the data files that lie beside a folder's modules."""
        if folder not in self._data:
            paths = _data_files(folder)
            digests = {p.relative_to(self.root).as_posix(): digest_file(p) for p in paths}
            self._data[folder] = digests
        return self._data[folder]


def closure(entry: str, sources: Sources) -> Closure:
    """Follow the imports of module ``entry`` within its own package.

    The digest covers the syntax trees without docstrings, those of fields too (comments are not
    part of them), and the data files that lie beside the modules.

    Raises:
        UserError: the entry module does not exist or a module does not parse.
    """
    package = entry.partition(".")[0]
    if sources.find(entry) is None:
        raise UserError(f"expected the stage's module {entry} below {sources.root}, found none")
    found: dict[str, str] = {}
    folders: set[Path] = set()
    third_party: set[str] = set()
    waiting, seen = [entry], set[str]()
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        seen.add(name)
        path = sources.find(name)
        if path is None:  # a function or class, not a module
            continue
        module = sources.module(name, path)
        found[name] = module.digest
        folders.add(path.parent)
        waiting += _parents(name)
        for target in module.imports:
            if target.partition(".")[0] == package:
                waiting.append(target)
            else:
                third_party.add(target.partition(".")[0])
    parts = {name: found[name] for name in sorted(found)}
    data = {name: digest for folder in folders for name, digest in sources.data(folder).items()}
    parts |= {name: data[name] for name in sorted(data, key=Path)}
    packages = sorted(third_party - sys.stdlib_module_names)
    return Closure(tuple(sorted(found)), tuple(packages), parts)


def _find(root: Path, name: str) -> Path | None:
    stem = f"{root}/{name.replace('.', '/')}"
    found = next((path for path in (f"{stem}.py", f"{stem}/__init__.py") if isfile(path)), None)
    return None if found is None else Path(found)


def _parents(name: str) -> list[str]:
    """Packages on the way: importing a.b.c runs the __init__ files of a and a.b."""
    parts = name.split(".")
    return [".".join(parts[:end]) for end in range(1, len(parts))]


def _data_files(folder: Path) -> Iterator[Path]:
    """Data files here and in sub-folders that are no packages."""
    for path in folder.iterdir():
        if path.is_dir() and path.name != "__pycache__" and not any(path.glob("*.py")):
            yield from _data_files(path)
        elif path.is_file() and _is_data(path.name):
            yield path


def _is_data(name: str) -> bool:
    """Tell whether a file is of a kind that the package ships, not what a file manager leaves."""
    return name.endswith(DATA) and not name.startswith((".", "#"))
