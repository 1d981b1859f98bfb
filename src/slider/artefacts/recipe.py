"""Recipes: digests of everything that may change the result of a stage.

Modules and packages that a stage imports are read from the syntax trees, so that no stage has to be
imported to learn its recipe.
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
"""Endings of data files, which a source digest covers where they lie beside its modules."""
Groups = Mapping[str, Sequence[str]]
"""Name of an input → digests, in order."""
_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")  # where the syntax has statements
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True)
class Code:
    """What runs: the entry point ``module:function``, its source digest, third-party versions.

    ``parts`` are the digests of the modules and data files behind ``source``, where they are known.
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
    """Digests of the modules and data files behind ``entry``; third-party packages.

    Imports are followed within the entry module's own package below a folder.

    Digests are those of syntax trees without docstrings, those of fields too (comments are not part
    of them), and those of the data files that lie beside the modules.

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
    """Digest of a module, what it imports (modules, or names in them), data files beside it."""

    digest: str
    imports: Sequence[str]
    data: Mapping[str, str]


@cache
def read_module(name: str, root: Path) -> Module | None:
    """A module as it was when first read; nothing where the name is a function's or a class's."""
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
            imports |= {base, *(f"{base}.{alias.name}" for alias in node.names)}  # maybe modules
        elif isinstance(node, _DOCUMENTED):
            node.body = [item for item in node.body if not _is_text(item)]
    digest = hashlib.sha256(ast.dump(tree).encode()).hexdigest()
    return Module(digest, sorted(imports), _data(path.parent, root))


def _statements(tree: ast.Module) -> Iterator[ast.AST]:
    """The module and all its statements. Expressions, most of a tree, hold none."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        for block in _BLOCKS:
            waiting += getattr(node, block, ())
        yield node


def _is_text(node: ast.stmt) -> bool:
    """A string by itself: the docstring of a module, class, function or field."""
    value = node.value if isinstance(node, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


@cache
def _data(folder: Path, root: Path) -> dict[str, str]:
    """Digests of data files here and in sub-folders that are no packages.

    They have names as modules have. Those that editors, systems and sync clients add do not, such
    as ``a.sync-conflict-1.csv`` and ``a (copy).csv``.
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
    """Versions of Python (major.minor) and of top-level packages, sorted; ``absent`` for none.

    Raises:
        UserError: a package can be imported, but no installed distribution provides it.
    """
    python = {"python": f"{sys.version_info.major}.{sys.version_info.minor}"}
    return python | {name: _version(name) for name in sorted(packages)}


@cache
def _version(package: str) -> str:
    """Version of the distribution that provides a package: its metadata are parsed each time."""
    found = distribution(package)
    return found.version if found else NOT_INSTALLED


def distribution(package: str) -> metadata.Distribution | None:
    """Distribution that provides an importable package, if that is installed.

    Raises:
        UserError: the package can be imported, but no installed distribution provides it.
    """
    try:
        return metadata.distribution(package)
    except metadata.PackageNotFoundError:
        if importlib.util.find_spec(package) is None:
            return None
    # metadata.packages_distributions() parses every list of files and takes 0.7 s; the
    # names of two of ten packages differ from their distribution's, so a text search will do.
    # The packages of cmeel (pinocchio) are one folder of site-packages below another.
    markers = (f"\n{package}/", f"\n{package}.py,", f"/site-packages/{package}/__init__.py,")
    for candidate, record in _records():
        if any(marker in record for marker in markers):
            return candidate
    raise UserError(f"expected an installed distribution with package {package}, found none")


@cache
def _records() -> list[tuple[metadata.Distribution, str]]:
    """Installed distributions with their lists of files."""
    return [(d, "\n" + (d.read_text("RECORD") or "")) for d in metadata.distributions()]
