"""The index behind the early cut-off: same code, section and input contents → known result.

A recipe names the way to a result, down to the recipes of the inputs. After a refactoring that
leaves the inputs' content as it was, recipes differ but the key of this index does not.
"""

from dataclasses import dataclass
from pathlib import Path

from slider.artefacts.store import Result, Store, parse_result, result_values
from slider.core import files


@dataclass(frozen=True)
class Entry:
    """A known result and the recipe that it was computed for."""

    recipe: str
    result: Result


@dataclass(frozen=True)
class Index:
    """Known results of a store."""

    store: Store

    def path(self, key: str) -> Path:
        """File of a key."""
        return self.store.root / "index" / key[:2] / f"{key}.json"

    def add(self, key: str, entry: Entry) -> None:
        """Remember a result whose object is in place."""
        files.write_json(self.path(key), {"recipe": entry.recipe} | result_values(entry.result))

    def find(self, key: str) -> Entry | None:
        """Known result of a key, if its object is there with all files in their sizes."""
        entry = read_entry(self.path(key))
        if entry is None:
            return None
        folder = self.store.object_folder(entry.result.object)
        return entry if files.has_files(folder, entry.result.files) else None

    def paths(self) -> list[Path]:
        """Every entry of the index."""
        return sorted((self.store.root / "index").glob("*/*.json"))


def read_entry(path: Path) -> Entry | None:
    """Read an entry; one that is missing or unreadable counts as none."""
    try:
        values = files.read_json(path)
        return Entry(values["recipe"], parse_result(values))
    except (OSError, ValueError, KeyError, TypeError):
        return None
