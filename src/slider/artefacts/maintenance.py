"""Care of the store: list, verify, date, remove what no recent plan reaches."""

import os
import shutil
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import NamedTuple

from slider.artefacts.manifest import Result, parse_manifest, readable
from slider.artefacts.plan import plan_paths, plan_recipes
from slider.artefacts.store import FOLDERS, Store, nobody_else
from slider.core import files
from slider.core.errors import UserError


class Kind(NamedTuple):
    """Numbers of one stage: manifests, different objects and their size [bytes]."""

    stage: str
    manifests: int
    objects: int
    size: int


@dataclass(frozen=True)
class Removed:
    """Names of what was removed, or would be.

    ``derived`` are manifests of what came from the objects, ``unreadable`` are other files.
    """

    objects: list[str]
    manifests: list[str]
    derived: list[str] = field(default_factory=list)
    unreadable: list[str] = field(default_factory=list)

    @property
    def damage(self) -> list[str]:
        """Lines about what was removed because of damage or loss."""
        return [
            *(f"{name}, unreadable" for name in self.unreadable),
            *(f"object {digest}, damaged" for digest in self.objects),
            *(f"{name}, computed from a damaged object" for name in self.derived),
            *(f"{name}, without its object" for name in self.manifests),
        ]


def summarise(store: Store) -> list[Kind]:
    """Count manifests, objects and bytes per stage."""
    stages: dict[str, list[Result]] = {}
    for manifest in filter(None, map(store.usable, store.manifests())):
        stages.setdefault(manifest.stage, []).append(manifest.result)
    kinds = []
    for stage, results in sorted(stages.items()):
        sizes = {result.object: result.size for result in results}
        kinds.append(Kind(stage, len(results), len(sizes), sum(sizes.values())))
    return kinds


def verify(store: Store) -> Removed:
    """Read every object; drop the corrupt ones, what leads to them and all that came from them.

    Whatever else cannot be read is removed, so that the next run writes it again.

    Raises:
        UserError: a job is running.
    """
    misplaced = free_places(store)
    with nobody_else(store.locks):
        unreadable = _names(store, [*misplaced, *drop_unreadable(store)])
        corrupt = {digest for digest in _objects(store) if not store.rehash(digest)}
        derived = _derived(store, corrupt)
        for path in derived:
            path.unlink(missing_ok=True)
        removed = _drop(store, corrupt, store.manifests())
        derived = [path for path in derived if path.parent.parent == store.root]
        return replace(removed, derived=_names(store, derived), unreadable=unreadable)


def drop_damaged(store: Store, manifests: Iterable[Path]) -> Removed:
    """Drop those of some manifests that have no whole object, reading what may have changed.

    Results that came from a damaged object stay: its content was checked when they were computed,
    so that was before the damage.
    """
    manifests = list(manifests)
    digests = {manifest.result.object for manifest in map(store.usable, manifests) if manifest}
    return _drop(store, {d for d in digests if not store.is_whole(d)}, manifests)


def _drop(store: Store, corrupt: set[str], manifests: list[Path]) -> Removed:
    for digest in corrupt:
        store.drop_object(digest)
    if corrupt:
        store.drop_dangling(store.index())
    return Removed(sorted(corrupt), _names(store, store.drop_dangling(manifests)))


def _derived(store: Store, corrupt: set[str]) -> list[Path]:
    """Manifests and index entries of what was computed from objects, directly or not."""
    manifests = {path: readable(path) for path in (*store.manifests(), *store.index())}
    others = {path: m for path, m in manifests.items() if m and m.result.object not in corrupt}
    recipes = {m.recipe for m in manifests.values() if m and m.result.object in corrupt}
    derived: list[Path] = []
    while True:
        following = [
            path
            for path, manifest in others.items()
            if recipes.intersection(chain(*manifest.inputs.values()))
            or corrupt.intersection(chain(*manifest.input_objects.values()))
        ]
        if not following:
            return sorted(derived)
        derived += following
        recipes |= {others.pop(path).recipe for path in following}


def date_now(store: Store, paths: Iterable[Path]) -> int:
    """Date files of the future now, by the clock of their file system; count them.

    The clock was set back after they were written. Results of them would be older than they are,
    which Snakemake refuses.
    """
    now = store.clock()
    late = [path for path in paths if now and path.is_file() and path.stat().st_mtime_ns > now]
    for path in late:
        os.utime(path, ns=(now, now))
    return len(late)


def collect(store: Store, keep: int, dry_run: bool = False) -> Removed:
    """Remove objects and manifests that none of the ``keep`` latest plans reaches, and litter.

    Raises:
        UserError: a job is running, no plan would be kept, or one cannot be read.
    """
    if keep < 1:
        raise UserError(f"--keep: expected at least 1 plan, found {keep}")
    with nobody_else(store.locks):
        plans = plan_paths(store.root / "plans")
        recipes = set().union(*map(plan_recipes, plans[:keep]))
        manifests = [path for path in store.manifests() if path.stem not in recipes]
        reached = (store.usable(path) for path in store.manifests() if path.stem in recipes)
        reachable = {manifest.result.object for manifest in reached if manifest}
        objects = [digest for digest in _objects(store) if digest not in reachable]
        if not dry_run:
            for path in (*manifests, *plans[keep:]):  # before their objects: none must dangle
                path.unlink(missing_ok=True)
            for digest in objects:
                store.drop_object(digest)
            store.drop_dangling([*store.index(), *store.manifests()])
            _drop_litter(store, recipes)
        return Removed(objects, _names(store, manifests))


def _drop_litter(store: Store, recipes: set[str]) -> None:
    """Unfinished results, caches, half-written files; work, logs, facts of forgotten recipes."""
    for name in ("tmp", "cache", "sources", "seals"):  # the last two of earlier versions
        shutil.rmtree(store.root / name, ignore_errors=True)
    for path in store.root.rglob(files.TEMPORARY_PATTERN):
        path.unlink(missing_ok=True)
    for path in store.root.glob("work/*/*"):
        if path.name not in recipes:
            shutil.rmtree(path)
    for path in (*store.root.glob("logs/*/*.log"), *store.root.glob("*/*.run.json")):
        if path.name.partition(".")[0] not in recipes:
            path.unlink(missing_ok=True)


def _names(store: Store, paths: Iterable[Path]) -> list[str]:
    return [path.relative_to(store.root).as_posix() for path in paths]


def _objects(store: Store) -> list[str]:
    """Names of objects, whatever is in them."""
    return sorted(path.name for path in (store.root / "objects").glob("*/*"))


_INNER = ("objects/*", "index/*", "integrity/*", "work/*", "work/*/*", "logs/*", "cache/*")


def free_places(store: Store) -> list[Path]:
    """Remove files where folders must be, folders where locks must be, objects without a name."""
    stages: set[str] = set()
    for path in store.root.glob("plans/*.json"):
        with suppress(OSError, ValueError, KeyError, TypeError, AttributeError):
            stages |= {str(job["stage"]) for job in files.read_json(path)["jobs"].values()}
    outer = (*FOLDERS, "tracking", "cache", *filter(str.isidentifier, stages))
    places = (path for pattern in (*outer, *_INNER) for path in store.root.glob(pattern))
    wrong = [path for path in places if "." not in path.name and not path.is_dir()]
    wrong += [path for path in store.locks.glob("*.lock") if path.is_dir()]
    objects = store.root.glob("objects/*/*")
    wrong += [path for path in objects if path.name[:2] != path.parent.name or len(path.name) != 64]
    return _removed(wrong)


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
    manifest = parse_manifest(path)
    return (manifest.stage, manifest.recipe) == (path.parent.name, path.stem)


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
