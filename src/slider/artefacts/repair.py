"""Repair of what surrounds the objects: places, locks, plans, entries and notes nobody can read."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from slider.artefacts.plan import plan_recipes
from slider.artefacts.store import Store, parse_manifest
from slider.core import files
from slider.core.errors import UserError

_FOLDERS = (
    *("objects", "index", "seals", "plans", "current", "locks", "work", "logs", "tmp"),
    *("objects/*", "index/*", "work/*", "work/*/*", "tracking", "cache", "cache/*"),
)


def free_places(store: Store) -> list[Path]:
    """Remove files where folders must be, folders where locks must be, objects without a name."""
    places = (path for name in (*_FOLDERS, *_stages(store)) for path in store.root.glob(name))
    wrong = [path for path in places if not path.is_dir()]
    wrong += [path for path in store.locks.glob("*.lock") if path.is_dir()]
    objects = store.root.glob("objects/*/*")
    wrong += [path for path in objects if path.name[:2] != path.parent.name or len(path.name) != 64]
    return _removed(wrong)


def _stages(store: Store) -> set[str]:
    """Names of the stages of all plans, whose folders hold manifests."""
    found: set[str] = set()
    for path in store.root.glob("plans/*.json"):
        with suppress(OSError, ValueError, KeyError, TypeError, AttributeError):
            found |= {str(job["stage"]) for job in files.read_json(path)["jobs"].values()}
    return {name for name in found if name.isidentifier()}


def drop_unreadable(store: Store) -> list[Path]:
    """Remove plans, manifests, index entries, notes and markers that cannot be read.

    Whoever needs one writes it again.
    """
    return _removed(
        path for paths, read in _readers(store) for path in paths if not _is_readable(path, read)
    )


def _readers(store: Store) -> Iterator[tuple[list[Path], Callable[[Path], Any]]]:
    yield sorted((store.root / "plans").glob("*.json")), _read_plan
    yield store.manifests(), _read_manifest
    yield store.index(), parse_manifest
    yield sorted(store.root.glob("*/*.run.json")), _read_facts
    yield sorted((store.root / "current").glob("*")), lambda path: path.read_text("utf-8")


def _read_plan(path: Path) -> None:
    plan_recipes(path)
    if files.digest_value(files.read_json(path)) != path.stem:
        raise ValueError("expected the plan that the name says")


def _read_manifest(path: Path) -> None:
    found = parse_manifest(path)
    if (found.stage, found.recipe) != (path.parent.name, path.stem):
        raise ValueError("expected the manifest that the name says")


def _read_facts(path: Path) -> None:
    if not isinstance(files.read_json(path), dict):
        raise ValueError("expected facts by name")


def _is_readable(path: Path, read: Callable[[Path], Any]) -> bool:
    try:
        read(path)
    except (OSError, ValueError, UserError):
        return False
    return True


def _removed(found: Iterator[Path] | list[Path]) -> list[Path]:
    paths = list(found)
    for path in paths:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    return paths
