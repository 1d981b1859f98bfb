"""Care of the store: list, verify, remove what no recent plan reaches."""

import os
import re
import shutil
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

from slider.artefacts.manifest import Manifest, OtherVersionError, Result, parse_manifest
from slider.artefacts.plan import plan_paths, plan_text, read_plan
from slider.artefacts.run_metadata import parse_metadata
from slider.artefacts.store import Store, nobody_else
from slider.core import files
from slider.core.errors import NotReadError, UserError, not_read, require

_REMOVALS = 16  # at once


@dataclass(frozen=True)
class Removed:
    """Names of what was removed, or would be.

    ``derived`` are manifests of what came from the objects, ``unreadable`` are damaged files.
    ``left`` are lines about what cannot be read, ``others`` counts files of other versions.
    """

    objects: list[str]
    manifests: list[str]
    derived: list[str] = field(default_factory=list)
    unreadable: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    others: int = 0

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
    """Read everything; drop the corrupt objects, what leads to them and all that came from them.

    Damaged plans, manifests, index entries and run metadata go, too. What cannot
    be read, and what another version of this project wrote, stays.

    Raises:
        UserError: a job is running, or a folder cannot be listed.
    """
    with nobody_else(store.locks):
        plans, index = plan_paths(store.root / "plans"), store.index()
        objects = dict.fromkeys(store.objects(), False)
        manifests: dict[Path, Manifest] = {}
        unreadable, left, others = [], [], 0
        readers = dict.fromkeys(plans, read_plan) | dict.fromkeys(index, parse_manifest)
        readers |= dict.fromkeys(store.metadata_files(), parse_metadata)
        readers |= dict.fromkeys(store.manifests(), partial(_parse_in_place, store))
        for path, read in readers.items():
            try:
                record = read(path)
            except OtherVersionError:
                others += 1
            except NotReadError as error:
                left.append(str(error))
            except UserError:
                unreadable.append(path)
            else:
                if isinstance(record, Manifest):
                    manifests[path] = record
        for digest in objects:
            try:
                objects[digest] = store.is_whole(digest)
            except NotReadError as error:
                left.append(str(error))
                objects[digest] = True
        corrupt = {digest for digest, whole in objects.items() if not whole}
        lost = [path for path, m in manifests.items() if not objects.get(m.result.object)]
        derived = _derived(manifests, corrupt)
        _unlink([*unreadable, *lost, *derived])  # before their objects: none must dangle
        _in_threads(store.drop_object, corrupt)
        lost, derived = (_names(store, {*paths}.difference(index)) for paths in (lost, derived))
        return Removed(sorted(corrupt), lost, derived, _names(store, unreadable), left, others)


def _parse_in_place(store: Store, path: Path) -> Manifest:
    manifest = parse_manifest(path)
    require(path == store.manifest_path(manifest.stage, manifest.recipe), str(path), "", "")
    return manifest


def drop_damaged(store: Store, manifests: Iterable[Path], dry_run: bool = False) -> list[str]:
    """Remove those of some manifests that lead to no whole object; describe what is the matter.

    Results that came from a damaged object stay: its content was checked when they were computed,
    so that was before the damage. The object goes when it is computed again. What cannot be read
    stays.
    """
    lines: list[str] = []
    for path in filter(os.path.lexists, manifests):
        try:
            digest = parse_manifest(path).result.object
            if store.is_whole(digest):
                continue
            there = store.object_folder(digest).exists()
            reason = "with a damaged object" if there else "without its object"
        except NotReadError as error:
            lines.append(f"{error}; it stays")
            continue
        except UserError:
            reason = "unreadable"
        if not dry_run:
            path.unlink()
        lines.append(f"{'found' if dry_run else 'dropped'} {_names(store, [path])[0]}, {reason}")
    return lines


def _derived(manifests: Mapping[Path, Manifest], corrupt: set[str]) -> list[Path]:
    """Manifests and index entries of what was computed from objects, directly or not."""
    others = {path: m for path, m in manifests.items() if m.result.object not in corrupt}
    recipes = {m.recipe for m in manifests.values() if m.result.object in corrupt}
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


def collect(store: Store, keep: int, dry_run: bool = False) -> Removed:
    """Remove objects and manifests that none of the ``keep`` latest plans reaches, and litter.

    Plans and manifests count by the digests in their text, whatever version wrote them.

    Raises:
        UserError: a job is running, no plan would be kept, or something cannot be read.
    """
    require(keep >= 1, "--keep", "at least 1 plan", keep)
    with nobody_else(store.locks):
        plans = plan_paths(store.root / "plans")
        try:
            recipes = {digest for path in plans[:keep] for digest in _digests(plan_text(path))}
        except NotReadError:
            raise
        except UserError as error:
            raise UserError(f"{error}; `slider store verify` drops it") from None
        manifests, reachable = [], set[str]()
        for path in store.manifests():
            if path.stem in recipes:
                reachable |= _digests(_text(path))
            else:
                manifests.append(path)
        objects = [digest for digest in store.objects() if digest not in reachable]
        if not dry_run:
            lost = {*objects}
            index = [path for path in store.index() if not lost.isdisjoint(_digests(_text(path)))]
            _unlink([*manifests, *index, *plans[keep:]])  # before their objects: none must dangle
            _in_threads(store.drop_object, objects)
            _drop_litter(store, recipes)
        return Removed(objects, _names(store, manifests))


def _digests(text: str) -> set[str]:
    return {*re.findall("[0-9a-f]{64}", text)}


def _text(path: Path) -> str:
    try:
        return path.read_text("utf-8", "replace")
    except OSError as error:
        raise not_read(error, path) from None


def _drop_litter(store: Store, recipes: set[str]) -> None:
    """Unfinished results, caches, half-written files; what is beside results of lost recipes."""
    for folder in (store.tmp, store.root / "cache"):
        shutil.rmtree(folder, ignore_errors=True)
    folders = (path for path in files.entries(store.root) if path.name != "objects")
    _unlink(path for folder in folders for path in folder.rglob(files.TEMPORARY_PATTERN))
    for path in store.root.glob("work/*/*"):
        if path.name not in recipes:
            shutil.rmtree(path)
    noted = (*store.root.glob("logs/*/*"), *store.metadata_files())
    _unlink(path for path in noted if path.name.partition(".")[0] not in recipes)


def _unlink(paths: Iterable[Path]) -> None:
    _in_threads(partial(Path.unlink, missing_ok=True), paths)


def _in_threads(remove: Callable[[Any], None], those: Iterable[Any]) -> None:
    """Disks answer several removals at once."""
    with ThreadPoolExecutor(_REMOVALS) as pool:
        deque(pool.map(remove, those), maxlen=0)


def _names(store: Store, paths: Iterable[Path]) -> list[str]:
    return [path.relative_to(store.root).as_posix() for path in sorted(paths)]
