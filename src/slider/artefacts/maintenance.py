"""Care of the store: list, verify, remove what no recent plan reaches."""

import shutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from slider.artefacts.index import Index, read_entry
from slider.artefacts.locks import nobody_else
from slider.artefacts.plan import plan_recipes
from slider.artefacts.store import Store, parse_manifest
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
    for path in store.manifests():
        result = parse_manifest(path).result
        stage = path.parent.name
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
        return Removed(corrupt, _drop_references(store, lambda name: not _is_there(store, name)))


def collect(store: Store, keep: int, dry_run: bool = False) -> Removed:
    """Remove objects and manifests that none of the ``keep`` latest plans reaches, and litter.

    Raises:
        UserError: a job is running, or no plan would be kept.
    """
    if keep < 1:
        raise UserError(f"--keep: expected at least 1 plan, found {keep}")
    with nobody_else(store.locks):
        plans = sorted(_plans(store), key=lambda path: path.stat().st_mtime, reverse=True)
        recipes = _reached(plans[:keep])
        manifests = [path for path in store.manifests() if path.stem not in recipes]
        kept = {parse_manifest(p).result.object for p in store.manifests() if p.stem in recipes}
        objects = [digest for digest in _objects(store) if digest not in kept]
        if not dry_run:
            _remove(store, plans[keep:], manifests, objects, recipes)
        return Removed(objects, [str(path.relative_to(store.root)) for path in manifests])


def _remove(
    store: Store, plans: list[Path], manifests: list[Path], objects: list[str], recipes: set[str]
) -> None:
    for path in manifests:  # before their objects: a manifest without its object is a lie
        _drop_manifest(store, path)
    for digest in objects:
        store.drop_object(digest)
    for path in plans:
        path.unlink(missing_ok=True)
    _drop_references(store, lambda name: not _is_there(store, name))
    _drop_litter(store, recipes)


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


def _drop_references(store: Store, gone: Callable[[str], bool]) -> list[str]:
    """Drop index entries and manifests whose object is gone; list the manifests."""
    for path in Index(store).paths():
        entry = read_entry(path)
        if entry is None or gone(entry.result.object):
            path.unlink(missing_ok=True)
    dropped = [path for path in store.manifests() if _is_void(path, gone)]
    for path in dropped:
        _drop_manifest(store, path)
    return [str(path.relative_to(store.root)) for path in dropped]


def _is_void(path: Path, gone: Callable[[str], bool]) -> bool:
    try:
        return gone(parse_manifest(path).result.object)
    except UserError:
        return True


def _drop_manifest(store: Store, path: Path) -> None:
    path.unlink(missing_ok=True)
    store.sidecar_path(path.parent.name, path.stem).unlink(missing_ok=True)


def _is_there(store: Store, digest: str) -> bool:
    return store.object_folder(digest).is_dir()


def _objects(store: Store) -> list[str]:
    return sorted(path.name for path in (store.root / "objects").glob("*/*"))


def _plans(store: Store) -> list[Path]:
    return list((store.root / "plans").glob("*.json"))


def _reached(plans: Iterable[Path]) -> set[str]:
    return set().union(*map(plan_recipes, plans))
