"""What code a stage really imports: its modules within a package, and third-party packages.

Found statically, on the syntax tree, so that no stage has to be imported to learn its recipe.
"""

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from os.path import isfile
from pathlib import Path

from slider.artefacts.source.analyses import analyses_of
from slider.artefacts.source.syntax import Module
from slider.core.errors import UserError
from slider.core.files import digest_file, digest_text

DATA = (".css", ".csv", ".html", ".js", ".json", ".txt", ".xml", ".yaml")
"""Endings of data files, which a source digest covers where they lie beside its modules."""


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
        """What a module says.

        Raises:
            UserError: it does not parse.
        """
        if name not in self._modules:
            package = self.root / name.partition(".")[0]
            self._modules[name] = analyses_of(package).read(path, name)
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
    analyses_of(sources.root / package).keep()
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
