"""What code a stage really imports: its modules within a package, and third-party packages.

Found statically, on the syntax tree, so that no stage has to be imported to learn its recipe.
"""

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from os.path import isfile
from pathlib import Path

from slider.artefacts.source.analyses import analyses_of
from slider.core.errors import UserError
from slider.core.files import digest_file, digest_text


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
    analyses = analyses_of(root / package)
    found: dict[str, str] = {}
    folders: set[Path] = set()
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
        module = analyses.read(path, name)
        found[name] = module.digest
        folders.add(path.parent)
        waiting += _parents(name)
        for target in module.imports:
            if target.partition(".")[0] == package:
                waiting.append(target)
            else:
                third_party.add(target.partition(".")[0])
    analyses.keep()
    parts = {name: found[name] for name in sorted(found)}
    for path in sorted(data for folder in folders for data in _data_files(folder)):
        parts[path.relative_to(root).as_posix()] = digest_file(path)
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
