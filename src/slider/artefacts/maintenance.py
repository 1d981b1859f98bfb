"""Care of the store: list, verify, remove what no recent plan reaches."""

import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from slider.artefacts.locks import nobody_else
from slider.artefacts.plan import plan_recipes
from slider.artefacts.store import Store
from slider.core import files
from slider.core.errors import UserError


@dataclass(frozen=True)
class Kind:
    """What the store holds of one stage: manifests, different objects and their size [bytes]."""

    stage: str
    manifests: int
    objects: int
    size: int


@dataclass(frozen=True)
class Removed:
    """Names of what was removed, or would be."""

    objects: list[str]
    manifests: list[str]


def summarise(store: Store) -> list[Kind]:
    """Count manifests, objects and bytes per stage."""
    sizes: dict[str, dict[str, int]] = {}
    counts: dict[str, int] = {}
    for manifest in filter(None, map(store.usable, store.manifests())):
        stage, result = manifest.stage, manifest.result
        counts[stage] = counts.get(stage, 0) + 1
        size = sum(facts["size"] for facts in result.files.values())
        sizes.setdefault(stage, {})[result.object] = size
    return [
        Kind(stage, counts[stage], len(objects), sum(objects.values()))
        for stage, objects in sorted(sizes.items())
    ]


def verify(store: Store) -> Removed:
    """Rehash every object; drop the corrupt ones with the manifests and index entries to them.

    Raises:
        UserError: a job is running.
    """
    with nobody_else(store.locks):
        corrupt = [digest for digest in _objects(store) if not store.is_whole(digest)]
        for digest in corrupt:
            store.drop_object(digest)
        return Removed(corrupt, _names(store, _drop_dangling(store)))


def collect(store: Store, keep: int, dry_run: bool = False) -> Removed:
    """Remove objects and manifests that none of the ``keep`` latest plans reaches, and litter.

    Raises:
        UserError: a job is running, no plan would be kept, or one cannot be read.
    """
    if keep < 1:
        raise UserError(f"--keep: expected at least 1 plan, found {keep}")
    with nobody_else(store.locks):
        plans = sorted(_plans(store), key=lambda path: path.stat().st_mtime, reverse=True)
        recipes = set().union(*map(plan_recipes, plans[:keep]))
        manifests = [path for path in store.manifests() if path.stem not in recipes]
        reached = (store.usable(path) for path in store.manifests() if path.stem in recipes)
        kept = {manifest.result.object for manifest in reached if manifest}
        objects = [digest for digest in _objects(store) if digest not in kept]
        if not dry_run:
            for path in (*manifests, *plans[keep:]):  # before their objects: none must dangle
                path.unlink(missing_ok=True)
            for digest in objects:
                store.drop_object(digest)
            _drop_dangling(store)
            _drop_litter(store, recipes)
        return Removed(objects, _names(store, manifests))


def _drop_litter(store: Store, recipes: set[str]) -> None:
    """Unfinished results, half-written files, and work, logs and facts of forgotten recipes."""
    shutil.rmtree(store.root / "tmp", ignore_errors=True)
    for path in store.root.rglob(files.TEMPORARY_PATTERN):
        path.unlink(missing_ok=True)
    for path in store.root.glob("work/*/*"):
        if path.name not in recipes:
            shutil.rmtree(path)
    for path in (*store.root.glob("logs/*/*.log"), *store.root.glob("*/*.run.json")):
        if path.name.partition(".")[0] not in recipes:
            path.unlink(missing_ok=True)


def _drop_dangling(store: Store) -> list[Path]:
    """Drop index entries and manifests whose object is gone; list the manifests."""
    store.drop_dangling(store.index())
    return store.drop_dangling(store.manifests())


def _names(store: Store, paths: Iterable[Path]) -> list[str]:
    return [path.relative_to(store.root).as_posix() for path in paths]


def _objects(store: Store) -> list[str]:
    return sorted(path.name for path in (store.root / "objects").glob("*/*"))


def _plans(store: Store) -> list[Path]:
    return list((store.root / "plans").glob("*.json"))
