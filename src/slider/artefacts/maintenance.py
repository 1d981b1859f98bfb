"""Care of the store: list, verify, remove what no recent plan reaches."""

import shutil
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

from slider.artefacts.locks import nobody_else
from slider.artefacts.plan import plan_paths, plan_recipes
from slider.artefacts.recipe import Groups
from slider.artefacts.repair import drop_unreadable, free_places
from slider.artefacts.store import Store, readable
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
    """Names of what was removed, or would be.

    ``derived`` are manifests of what came from the objects, ``unreadable`` are other files.
    """

    objects: list[str]
    manifests: list[str]
    derived: list[str] = field(default_factory=list)
    unreadable: list[str] = field(default_factory=list)

    @property
    def damage(self) -> list[str]:
        """What went because of damage or loss, in words."""
        return [
            *(f"{name}, unreadable" for name in self.unreadable),
            *(f"object {digest}, damaged" for digest in self.objects),
            *(f"{name}, computed from a damaged object" for name in self.derived),
            *(f"{name}, without its object" for name in self.manifests),
        ]


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
    """Read every object; drop the corrupt ones, what leads to them and all that came from them.

    Whatever else cannot be read is removed, so that the next run writes it again.

    Raises:
        UserError: a job is running.
    """
    misplaced = free_places(store)
    with nobody_else(store.locks):
        unreadable = _names(store, [*misplaced, *drop_unreadable(store)])
        corrupt = {d for d in _objects(store) if not store.seals.read(d, store.object_folder(d))}
        removed = _drop(store, corrupt, store.manifests(), checked=True)
        return replace(removed, unreadable=unreadable)


def drop_damaged(store: Store, manifests: Iterable[Path]) -> Removed:
    """Drop of some manifests those without a whole object, reading what may have changed.

    What came from a damaged object is dropped if nobody checked its inputs when it was computed:
    the others were computed before the damage, and are good again once the object is.
    """
    named = {path: store.usable(path) for path in manifests if path.is_file()}
    found = {manifest.result.object for manifest in named.values() if manifest}
    corrupt = {digest for digest in found if not store.is_whole(digest)}
    if corrupt:
        return _drop(store, corrupt, list(named), checked=False)
    return Removed([], _names(store, store.drop_dangling(list(named))))


def _drop(store: Store, corrupt: set[str], manifests: list[Path], checked: bool) -> Removed:
    derived = _derived(store, corrupt, checked)
    for digest in corrupt:
        store.drop_object(digest)
    for path in derived:
        path.unlink(missing_ok=True)
    store.drop_dangling(store.index())
    dangling = store.drop_dangling(manifests)
    derived = [path for path in derived if path.parent.parent == store.root]
    return Removed(sorted(corrupt), _names(store, dangling), _names(store, derived))


def _derived(store: Store, corrupt: set[str], checked: bool) -> list[Path]:
    """Manifests and index entries of what was computed from objects, directly or not.

    Args:
        store: where they are.
        corrupt: the objects.
        checked: also those whose inputs were checked when they were computed.
    """
    known = {path: readable(path) for path in (*store.manifests(), *store.index())}
    left = {path: manifest for path, manifest in known.items() if manifest}
    recipes = {m.recipe for m in left.values() if m.result.object in corrupt}
    left = {path: m for path, m in left.items() if m.result.object not in corrupt}
    derived: list[Path] = []
    while True:
        found = [
            path
            for path, manifest in left.items()
            if (checked or manifest.input_objects is None)
            and (_meets(manifest.inputs, recipes) or _meets(manifest.input_objects or {}, corrupt))
        ]
        if not found:
            return sorted(derived)
        derived += found
        recipes |= {left.pop(path).recipe for path in found}


def _meets(groups: Groups, digests: set[str]) -> bool:
    return any(not digests.isdisjoint(group) for group in groups.values())


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
    """Unfinished results, caches, half-written files; work, logs, facts of forgotten recipes."""
    for name in ("tmp", "cache", "sources"):  # the last of an earlier version
        shutil.rmtree(store.root / name, ignore_errors=True)
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
    """Names of objects, whatever is in them."""
    return sorted(path.name for path in (store.root / "objects").glob("*/*"))
