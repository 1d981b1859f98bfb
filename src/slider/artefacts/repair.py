"""Repair of what surrounds the objects: places, locks, plans, entries and notes nobody can read."""

import shutil
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

from slider.artefacts.manifest import parse_manifest, readable
from slider.artefacts.plan import plan_recipes
from slider.artefacts.store import Store
from slider.core import files
from slider.core.errors import UserError

_FOLDERS = (
    *("objects", "index", "integrity", "plans", "current", "locks", "work", "logs", "tmp"),
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
    checks: dict[Callable[[Path], bool], Iterable[Path]] = {
        _is_plan: (store.root / "plans").glob("*.json"),
        _is_manifest: store.manifests(),
        lambda path: readable(path) is not None: store.index(),
        lambda path: isinstance(files.read_json(path), dict): store.root.glob("*/*.run.json"),
        lambda path: path.read_text("utf-8") is not None: (store.root / "current").glob("*"),
    }
    wrong = [p for check, paths in checks.items() for p in sorted(paths) if not _passes(check, p)]
    return _removed(wrong)


def _is_plan(path: Path) -> bool:
    return plan_recipes(path) is not None and files.digest_value(files.read_json(path)) == path.stem


def _is_manifest(path: Path) -> bool:
    found = parse_manifest(path)
    return (found.stage, found.recipe) == (path.parent.name, path.stem)


def _passes(check: Callable[[Path], bool], path: Path) -> bool:
    try:
        return check(path)
    except (OSError, ValueError, UserError):
        return False


def _removed(paths: list[Path]) -> list[Path]:
    for path in paths:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    return paths
