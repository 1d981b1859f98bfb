"""Recipes: digests of everything that may change the result of a stage.

Imports of a stage are read from the syntax trees, so that a recipe can be computed without
importing the stage.
"""

import ast
import hashlib
import importlib.util
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import slider
from slider.core.errors import UserError
from slider.core.files import digest_file, digest_text

SOURCE_ROOT = Path(slider.__file__).parent.parent
NOT_INSTALLED = "absent"
DATA = (".css", ".csv", ".html", ".js", ".json", ".txt", ".xml", ".yaml")
"""Suffixes of data files, which a source digest covers if they lie beside its modules."""
Groups = Mapping[str, Sequence[str]]
"""Name of an input → digests, in order."""
_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")  # fields that hold statements
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True)
class Code:
    """Code of a stage: entry point ``module:function``, source digest, third-party versions.

    ``parts`` are the digests of the modules and data files that ``source`` covers, if known.
    """

    entry: str
    source: str
    versions: dict[str, str]
    parts: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)


@cache
def code_of(entry: str, root: Path = SOURCE_ROOT) -> Code:
    """Source digest and third-party versions of an entry point.

    Raises:
        UserError: the module does not exist, does not parse or imports an unknown package.
    """
    parts, packages = closure(entry.partition(":")[0], root)
    source = digest_text("".join(f"{name} {digest}\n" for name, digest in parts.items()))
    return Code(entry, source, versions(packages), parts)


def closure(entry: str, root: Path) -> tuple[dict[str, str], tuple[str, ...]]:
    """Digests of the modules and data files that ``entry`` depends on; third-party packages.

    Imports are followed within the top-level package of the entry module, below ``root``.

    A module is digested as its syntax tree, without comments and docstrings (of fields, too). Data
    files beside the modules are included.

    Raises:
        UserError: the entry module does not exist or a module does not parse.
    """
    if read_module(entry, root) is None:
        raise UserError(f"expected the stage's module {entry} below {root}, found none")
    package = entry.partition(".")[0]
    modules, data, third_party = dict[str, str](), dict[str, str](), set[str]()
    waiting, seen = [entry], set[str]()
    while waiting:
        name = waiting.pop()
        if (top := name.partition(".")[0]) != package:
            third_party.add(top)
        elif name not in seen:
            seen.add(name)
            if module := read_module(name, root):
                modules[name] = module.digest
                data |= module.data
                waiting += module.imports
    parts = {name: group[name] for group in (modules, data) for name in sorted(group)}
    return parts, tuple(sorted(third_party - sys.stdlib_module_names))


class Module(NamedTuple):
    """Digest of a module, its imports (modules, or names in them), and data files beside it."""

    digest: str
    imports: Sequence[str]
    data: Mapping[str, str]


@cache
def read_module(name: str, root: Path) -> Module | None:
    """A module as it was when first read; None if the name is that of a function or class."""
    stem = root / name.replace(".", "/")
    paths = (stem.with_suffix(".py"), stem / "__init__.py")
    path = next((path for path in paths if path.is_file()), None)
    if path is None:
        return None
    try:
        tree = ast.parse(path.read_bytes())
    except SyntaxError as error:
        raise UserError(f"module {name}, line {error.lineno}: {error.msg}") from None
    parent = name.rpartition(".")[0]
    package = name if path.name == "__init__.py" else parent
    imports = {parent} - {""}  # importing a.b.c runs the __init__ files of a and a.b
    for node in _statements(tree):
        if isinstance(node, ast.Import):
            imports |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            relative = "." * node.level + (node.module or "")
            base = importlib.util.resolve_name(relative, package)
            imports |= {base, *(f"{base}.{alias.name}" for alias in node.names)}  # may be modules
        elif isinstance(node, _DOCUMENTED):
            node.body = [item for item in node.body if not _is_text(item)]
    digest = hashlib.sha256(ast.dump(tree).encode()).hexdigest()
    return Module(digest, sorted(imports), _data(path.parent, root))


def _statements(tree: ast.Module) -> Iterator[ast.AST]:
    """The module and all its statements; expressions, which are most of a tree, are skipped."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        for block in _BLOCKS:
            waiting += getattr(node, block, ())
        yield node


def _is_text(node: ast.stmt) -> bool:
    """Whether a statement is only a string: docstring of a module, class, function or field."""
    value = node.value if isinstance(node, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


@cache
def _data(folder: Path, root: Path) -> dict[str, str]:
    """Digests of data files in a folder and in sub-folders that are not packages.

    Only files whose stem is an identifier count, so that files added by editors, systems and sync
    clients do not, such as ``a.sync-conflict-1.csv`` and ``a (copy).csv``.
    """
    digests = {}
    for path in folder.iterdir():
        if not path.stem.isidentifier():
            continue
        if path.is_dir() and path.name != "__pycache__" and not any(path.glob("*.py")):
            digests |= _data(path, root)
        elif path.suffix in DATA and path.is_file():
            digests[path.relative_to(root).as_posix()] = digest_file(path)
    return digests


def versions(packages: Sequence[str]) -> dict[str, str]:
    """Versions of Python (major.minor) and of packages, sorted; ``absent`` if not installed.

    Raises:
        UserError: a package can be imported, but no installed distribution provides it.
    """
    python = {"python": f"{sys.version_info.major}.{sys.version_info.minor}"}
    return python | {name: _version(name) for name in sorted(packages)}


@cache
def _version(package: str) -> str:
    """Version of the distribution of a package; cached, since its metadata are parsed each time."""
    found = distribution(package)
    return found.version if found else NOT_INSTALLED


def distribution(package: str) -> metadata.Distribution | None:
    """Distribution that provides an importable package; None if it is not installed.

    Raises:
        UserError: the package can be imported, but no installed distribution provides it.
    """
    try:
        return metadata.distribution(package)
    except metadata.PackageNotFoundError:
        if importlib.util.find_spec(package) is None:
            return None
    # metadata.packages_distributions() parses every list of files and takes 0.7 s. Only two of
    # ten packages are named differently from their distribution, so a text search is enough.
    # Packages of cmeel (pinocchio) lie in a site-packages folder inside another one.
    markers = (f"\n{package}/", f"\n{package}.py,", f"/site-packages/{package}/__init__.py,")
    for candidate, record in _records():
        if any(marker in record for marker in markers):
            return candidate
    raise UserError(f"expected an installed distribution with package {package}, found none")


@cache
def _records() -> list[tuple[metadata.Distribution, str]]:
    """Installed distributions with their lists of files."""
    return [(d, "\n" + (d.read_text("RECORD") or "")) for d in metadata.distributions()]
