"""Care of the store: list, verify, remove what no recent plan reaches."""

import os
import re
import shutil
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from slider.artefacts.manifest import Manifest, OtherVersionError, Result, parse_manifest
from slider.artefacts.plan import plan_paths, plan_text, read_plan
from slider.artefacts.run_metadata import parse_metadata
from slider.artefacts.store import Store, nobody_else
from slider.core import files
from slider.core.errors import UserError, require


@dataclass(frozen=True)
class Removed:
    """Names of what was removed, or would be; ``unreadable`` are damaged files.

    ``others`` counts files of other versions, which stay.
    """

    objects: list[str]
    manifests: list[str]
    unreadable: list[str] = field(default_factory=list)
    others: int = 0

    @property
    def damage(self) -> list[str]:
        """Lines about what was removed because of damage or loss."""
        return [
            *(f"{name}, unreadable" for name in self.unreadable),
            *(f"object {digest}, damaged" for digest in self.objects),
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
    """Read everything; drop the corrupt objects and what leads to them.

    Damaged plans, manifests, index entries and run metadata go, too. What another version of this
    project wrote stays, and what came from a corrupt object: that was whole when it was used.

    Raises:
        UserError: a job is running.
        OSError: something cannot be read, which says nothing about it; nothing was removed.
    """
    with nobody_else(store.locks):
        plans, index = plan_paths(store.root / "plans"), store.index()
        manifests: dict[Path, Manifest] = {}
        unreadable, others = [], 0
        readers = dict.fromkeys(plans, read_plan) | dict.fromkeys(index, parse_manifest)
        readers |= dict.fromkeys(store.metadata_files(), parse_metadata)
        readers |= dict.fromkeys(store.manifests(), partial(_parse_in_place, store))
        for path, read in readers.items():
            try:
                record = read(path)
            except OtherVersionError:
                others += 1
            except UserError:
                unreadable.append(path)
            else:
                if isinstance(record, Manifest):
                    manifests[path] = record
        whole = {digest: store.is_whole(digest) for digest in store.objects()}
        corrupt = [digest for digest in whole if not whole[digest]]
        lost = [path for path, m in manifests.items() if not whole.get(m.result.object)]
        _unlink([*unreadable, *lost])  # before their objects: none must dangle
        for digest in corrupt:
            store.drop_object(digest)
        lost = {*lost}.difference(index)
        return Removed(corrupt, _names(store, lost), _names(store, unreadable), others)


def _parse_in_place(store: Store, path: Path) -> Manifest:
    manifest = parse_manifest(path)
    require(path == store.manifest_path(manifest.stage, manifest.recipe), str(path), "", "")
    return manifest


def drop_damaged(store: Store, manifests: Iterable[Path], dry_run: bool = False) -> list[str]:
    """Remove those of some manifests that lead to no whole object; describe what is the matter.

    The object goes when it is computed again.
    """
    lines: list[str] = []
    for path in filter(os.path.lexists, manifests):
        try:
            digest = parse_manifest(path).result.object
            if store.is_whole(digest):
                continue
            there = store.object_folder(digest).exists()
            reason = "with a damaged object" if there else "without its object"
        except UserError:
            reason = "unreadable"
        if not dry_run:
            path.unlink()
        lines.append(f"{'found' if dry_run else 'dropped'} {_names(store, [path])[0]}, {reason}")
    return lines


def collect(store: Store, keep: int, dry_run: bool = False) -> Removed:
    """Remove objects and manifests that none of the ``keep`` latest plans reaches, and litter.

    Plans and manifests count by the digests in their text, whatever version wrote them.

    Raises:
        UserError: a job is running, no plan would be kept, or one is damaged.
    """
    require(keep >= 1, "--keep", "at least 1 plan", keep)
    with nobody_else(store.locks):
        plans = plan_paths(store.root / "plans")
        recipes = {digest for path in plans[:keep] for digest in _digests(plan_text(path))}
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
            for digest in objects:
                store.drop_object(digest)
            _drop_litter(store, recipes)
        return Removed(objects, _names(store, manifests))


def _digests(text: str) -> set[str]:
    return {*re.findall("[0-9a-f]{64}", text)}


def _text(path: Path) -> str:
    return path.read_text("utf-8", "replace")


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
    for path in paths:
        path.unlink(missing_ok=True)


def _names(store: Store, paths: Iterable[Path]) -> list[str]:
    return [path.relative_to(store.root).as_posix() for path in sorted(paths)]
