"""Maintenance of the store: verify it, remove what no recent plan refers to."""

import os
import re
import shutil
from collections.abc import Iterable
from pathlib import Path

from slider.artefacts.manifest import readable
from slider.artefacts.plan import plan_paths
from slider.artefacts.run_metadata import STARTED
from slider.artefacts.store import Store, exclusive_store
from slider.core import files
from slider.core.errors import require


def verify(store: Store) -> list[str]:
    """Read everything and drop manifests without an intact object; see ``drop_damaged``.

    Raises:
        UserError: a job is running, or something cannot be read.
    """
    with exclusive_store(store.locks):
        return drop_damaged(store, store.manifests())


def drop_damaged(store: Store, manifests: Iterable[Path], dry_run: bool = False) -> list[str]:
    """Remove manifests that are unreadable or lack an intact object; return a line for each.

    Results computed from a damaged object are kept: its content was checked at that time, so the
    damage is more recent. The object is replaced when it is computed again.

    Raises:
        NotReadError: something cannot be read, which does not mean that it is damaged.
    """
    lines: list[str] = []
    for path in filter(os.path.lexists, manifests):
        manifest = readable(path)
        if manifest and store.is_intact(manifest.result.object):
            continue
        if not dry_run:
            path.unlink()
        reason = "with a damaged or lost object" if manifest else "unreadable"
        lines.append(f"{'found' if dry_run else 'dropped'} {_name(store, path)}, {reason}")
    return lines


def collect(store: Store, keep: int, dry_run: bool = False) -> list[str]:
    """Remove objects and manifests that none of the ``keep`` latest plans refers to; return names.

    References are all digests in the text of plans and manifests, whichever version wrote them.
    Temporary files, caches, and logs of removed results are deleted as well.

    Raises:
        UserError: a job is running, or no plan would be kept.
    """
    require(keep >= 1, "--keep", "at least 1 plan", keep)
    with exclusive_store(store.locks):
        plans = plan_paths(store.root / "plans")
        recipes = {digest for path in plans[:keep] for digest in _digests(path)}
        manifests, reachable = [], set[str]()
        for path in store.manifests():
            if path.stem in recipes:
                reachable |= _digests(path)
            else:
                manifests.append(path)
        lost = [digest for digest in store.objects() if digest not in reachable]
        if not dry_run:
            index = store.root.glob("index/*/*.json")
            leading = [path for path in index if not _digests(path).isdisjoint(lost)]
            started = (path.with_suffix(STARTED) for path in plans[keep:])
            for path in (*manifests, *leading, *plans[keep:], *started):  # before their objects
                path.unlink(missing_ok=True)
            for digest in lost:
                store.drop_object(digest)
            _drop_litter(store, recipes)
        return [*(f"object {digest}" for digest in lost), *(_name(store, p) for p in manifests)]


def _digests(path: Path) -> set[str]:
    return {*re.findall("[0-9a-f]{64}", path.read_text("utf-8", "replace"))}


def _drop_litter(store: Store, recipes: set[str]) -> None:
    """Remove unfinished results, caches, partial files; logs, metadata, work of other recipes."""
    for folder in (store.tmp, store.root / "cache"):
        shutil.rmtree(folder, ignore_errors=True)
    folders = (path for path in files.entries(store.root) if path.name != "objects")
    parts = [path for folder in folders for path in folder.rglob(files.TEMPORARY_PATTERN)]
    noted = (path for name in ("logs/*/*", "*/*.run.json") for path in store.root.glob(name))
    for path in (*parts, *(p for p in noted if p.name.partition(".")[0] not in recipes)):
        path.unlink()
    for path in store.root.glob("work/*/*"):
        if path.name not in recipes:
            shutil.rmtree(path)


def _name(store: Store, path: Path) -> str:
    return path.relative_to(store.root).as_posix()
