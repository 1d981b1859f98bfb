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

import slider
from slider.core.errors import UserError
from slider.core.files import digest_file, digest_text

SOURCE_ROOT = Path(slider.__file__).parent.parent
ABSENT = "absent"
DATA = (".css", ".csv", ".html", ".js", ".json", ".txt", ".xml", ".yaml")
"""Endings of data files, which a source digest covers where they lie beside its modules."""
Groups = Mapping[str, Sequence[str]]
"""Name of an input → digests, in order."""
_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")  # where the syntax has statements


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
    imported = closure(entry.partition(":")[0], sources_of(root))
    return Code(entry, imported.digest, versions(imported.third_party), imported.parts)


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
        self.find = cache(self._find)
        self.parse = cache(self._parse)
        self.data = cache(self._data)

    def _find(self, name: str) -> Path | None:
        """File of a module; nothing where the name is a function's or a class's."""
        stem = self.root / name.replace(".", "/")
        paths = (stem.with_suffix(".py"), stem / "__init__.py")
        return next((path for path in paths if path.is_file()), None)

    def _parse(self, name: str, path: Path) -> tuple[str, set[str]]:
        """Digest of a module's syntax tree without docstrings; imported names, modules or not."""
        try:
            tree = ast.parse(path.read_bytes())
        except SyntaxError as error:
            raise UserError(f"module {name}, line {error.lineno}: {error.msg}") from None
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        imports = set(_imports(tree, package))
        documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
        for node in _statements(tree):
            if isinstance(node, documented):
                node.body = [item for item in node.body if not _is_text(item)]
        return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), imports

    def _data(self, folder: Path) -> dict[str, str]:
        """Digests of the data files that lie beside a folder's modules."""
        return {p.relative_to(self.root).as_posix(): digest_file(p) for p in _data_files(folder)}


@cache
def sources_of(root: Path) -> Sources:
    """The sources below a folder, for all entry points."""
    return Sources(root)


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
    modules: dict[str, str] = {}
    data: dict[str, str] = {}
    third_party: set[str] = set()
    waiting, seen = [entry], set[str]()
    while waiting:
        name = waiting.pop()
        top, _, rest = name.partition(".")
        if top != package:
            third_party.add(top)
        elif name not in seen:
            seen.add(name)
            if (path := sources.find(name)) is None:  # a function or class, not a module
                continue
            modules[name], imports = sources.parse(name, path)
            data |= sources.data(path.parent)
            waiting += imports
            if rest:  # importing a.b.c runs the __init__ files of a and a.b
                waiting.append(name.rpartition(".")[0])
    parts = {name: modules[name] for name in sorted(modules)}
    parts |= {name: data[name] for name in sorted(data, key=Path)}
    packages = sorted(third_party - sys.stdlib_module_names)
    return Closure(tuple(sorted(modules)), tuple(packages), parts)


def _statements(tree: ast.Module) -> Iterator[ast.AST]:
    """The module and all its statements. Expressions, most of a tree, hold none."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        for block in _BLOCKS:
            waiting += getattr(node, block, ())


def _imports(tree: ast.Module, package: str) -> Iterator[str]:
    for node in _statements(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            relative = "." * node.level + (node.module or "")
            base = importlib.util.resolve_name(relative, package)
            yield base
            yield from (f"{base}.{alias.name}" for alias in node.names)  # maybe submodules


def _is_text(node: ast.stmt) -> bool:
    """A string by itself: the docstring of a module, class, function or field."""
    value = node.value if isinstance(node, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


def _data_files(folder: Path) -> Iterator[Path]:
    """Data files here and in sub-folders that are no packages, but not what file managers leave."""
    for path in folder.iterdir():
        if path.is_dir() and path.name != "__pycache__" and not any(path.glob("*.py")):
            yield from _data_files(path)
        elif path.name.endswith(DATA) and path.name[0] not in ".#" and path.is_file():
            yield path


def versions(packages: Sequence[str]) -> dict[str, str]:
    """Version of Python (major.minor) and of each importable top-level package, sorted.

    One that is not installed is ``absent``.

    Raises:
        UserError: a package can be imported, but no installed distribution provides it.
    """
    numbers = {"python": f"{sys.version_info.major}.{sys.version_info.minor}"}
    for name in sorted(packages):
        provider = distribution(name)
        numbers[name] = provider.version if provider else ABSENT
    return numbers


@cache
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
