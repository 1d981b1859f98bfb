"""Care of the store: list, verify, date, remove what no recent plan reaches."""

import os
import shutil
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path

from slider.artefacts.manifest import Result, readable
from slider.artefacts.plan import plan_paths, read_plan, readable_plan
from slider.artefacts.store import Store, nobody_else
from slider.core import files
from slider.core.errors import UserError, require


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


def summarise(store: Store) -> dict[str, tuple[int, int, int]]:
    """Numbers of each stage: manifests, different objects and their size [bytes]."""
    stages: dict[str, list[Result]] = {}
    for manifest in filter(None, map(store.present, store.manifests())):
        stages.setdefault(manifest.stage, []).append(manifest.result)
    numbers = {}
    for stage, results in sorted(stages.items()):
        sizes = {result.object: result.size for result in results}
        numbers[stage] = len(results), len(sizes), sum(sizes.values())
    return numbers


def verify(store: Store) -> Removed:
    """Read every object; drop the corrupt ones, what leads to them and all that came from them.

    Plans, manifests and index entries that cannot be read go, too; the next run writes them again.

    Raises:
        UserError: a job is running.
    """
    with nobody_else(store.locks):
        unreadable = [path for path in plan_paths(store.root / "plans") if not readable_plan(path)]
        for path in store.manifests():
            manifest = readable(path)
            if not manifest or path != store.manifest_path(manifest.stage, manifest.recipe):
                unreadable.append(path)
        unreadable += [path for path in store.index() if readable(path) is None]
        corrupt = {digest for digest in _objects(store) if not store.is_whole(digest)}
        derived = _derived(store, corrupt)
        _unlink([*unreadable, *derived])
        dropped = _drop(store, corrupt, store.manifests())
        shown = (path for path in derived if path.parent.parent == store.root)
        return replace(dropped, derived=_names(store, shown), unreadable=_names(store, unreadable))


def drop_damaged(store: Store, manifests: Iterable[Path]) -> Removed:
    """Drop those of some manifests that have no whole object.

    Results that came from a damaged object stay: its content was checked when they were computed,
    so that was before the damage.
    """
    manifests = list(manifests)
    digests = {manifest.result.object for manifest in map(store.present, manifests) if manifest}
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

    The clock was set back after they were written: Snakemake refuses results that are older than
    their inputs.
    """
    try:
        with store.temporary("clock") as folder:
            now = folder.stat().st_mtime_ns
    except OSError:  # a store without a place to write
        return 0
    late = [path for path in paths if path.is_file() and path.stat().st_mtime_ns > now]
    for path in late:
        os.utime(path, ns=(now, now))
    return len(late)


def collect(store: Store, keep: int, dry_run: bool = False) -> Removed:
    """Remove objects and manifests that none of the ``keep`` latest plans reaches, and litter.

    Raises:
        UserError: a job is running, no plan would be kept, or one cannot be read.
    """
    require(keep >= 1, "--keep", "at least 1 plan", keep)
    with nobody_else(store.locks):
        plans = plan_paths(store.root / "plans")
        try:
            recipes = {recipe for path in plans[:keep] for recipe in read_plan(path).jobs}
        except UserError as error:  # damaged, or of another version
            raise UserError(f"{error}; `slider store verify` drops it") from None
        manifests = [path for path in store.manifests() if path.stem not in recipes]
        reached = (readable(path) for path in store.manifests() if path.stem in recipes)
        reachable = {manifest.result.object for manifest in reached if manifest}
        objects = [digest for digest in _objects(store) if digest not in reachable]
        if not dry_run:
            _unlink([*manifests, *plans[keep:]])  # before their objects: none must dangle
            for digest in objects:
                store.drop_object(digest)
            store.drop_dangling([*store.index(), *store.manifests()])
            _drop_litter(store, recipes)
        return Removed(objects, _names(store, manifests))


def _drop_litter(store: Store, recipes: set[str]) -> None:
    """Unfinished results, caches, half-written files; work, logs, facts of forgotten recipes."""
    for name in ("tmp", "cache"):
        shutil.rmtree(store.root / name, ignore_errors=True)
    _unlink(store.root.rglob(files.TEMPORARY_PATTERN))
    for path in store.root.glob("work/*/*"):
        if path.name not in recipes:
            shutil.rmtree(path)
    noted = (*store.root.glob("logs/*/*"), *store.root.glob("*/*.run.json"))
    _unlink(path for path in noted if path.name.partition(".")[0] not in recipes)


def _unlink(paths: Iterable[Path]) -> None:
    for path in paths:
        path.unlink(missing_ok=True)


def _names(store: Store, paths: Iterable[Path]) -> list[str]:
    return [path.relative_to(store.root).as_posix() for path in paths]


def _objects(store: Store) -> list[str]:
    """Names of objects, whatever is in them."""
    return sorted(path.name for path in (store.root / "objects").glob("*/" + "[0-9a-f]" * 64))
