"""``slider store``: list, verify and clean the artefact store."""

import argparse
from pathlib import Path

from slider.artefacts.maintenance import Removed, collect, summarise, verify
from slider.artefacts.store import ARTEFACTS, Store
from slider.artefacts.times import mean_rows, times, write
from slider.core.errors import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "--artefacts", type=Path, default=Path(ARTEFACTS), help="folder (default: artefacts)"
    )
    actions = parser.add_subparsers(dest="action", required=True)
    actions.add_parser("ls", help="count manifests, objects and bytes of each stage")
    actions.add_parser("verify", help="rehash objects; drop what is corrupt or unreadable")
    gc = actions.add_parser("gc", help="remove what the latest plans do not reach")
    gc.add_argument("--keep", type=int, default=5, help="number of plans to keep (default: 5)")
    gc.add_argument("--dry-run", action="store_true", help="only say what would be removed")
    spent = actions.add_parser("times", help="mean seconds of the jobs of each kind, longest first")
    spent.add_argument("--out", type=Path, help="also write them as the table that ships")


def run(arguments: argparse.Namespace) -> int:
    """Run one action; ``verify`` ends with status 1 when it found something corrupt."""
    if not arguments.artefacts.is_dir():
        raise UserError(f"expected the artefact store, found none at {arguments.artefacts}")
    store = Store(arguments.artefacts)
    if arguments.action == "ls":
        return _list(store)
    if arguments.action == "verify":
        removed = verify(store)
        for name in removed.damage:
            print(f"dropped {name}")
        manifests = len(removed.manifests) + len(removed.derived)
        print(f"dropped {len(removed.objects)} objects, {manifests} manifests")
        return int(bool(removed.damage))
    if arguments.action == "times":
        return _times(store, arguments.out)
    dry_run = arguments.dry_run
    _report("would remove" if dry_run else "removed", collect(store, arguments.keep, dry_run))
    return 0


def _list(store: Store) -> int:
    print(f"{'stage':<14}{'manifests':>10}{'objects':>10}{'MB':>10}")
    for kind in summarise(store):
        size = kind.size / 1e6
        print(f"{kind.stage:<14}{kind.manifests:>10}{kind.objects:>10}{size:>10.2f}")
    return 0


def _times(store: Store, out: Path | None) -> int:
    """What later runs tell the time left by; a job of another size takes in proportion."""
    stages = sorted({path.parent.name for path in store.manifests()})
    rows = mean_rows(times(store, stages).remembered)
    print(f"{'kind':<28}{'size':>12}{'seconds':>10}")
    for row in rows:
        print(f"{row.kind:<28}{row.size:>12g}{row.seconds:>10.2f}")
    if out is not None:
        write(rows, out)
    return 0


def _report(verb: str, removed: Removed) -> None:
    for name in (*(f"object {digest}" for digest in removed.objects), *removed.manifests):
        print(f"{verb} {name}")
    print(f"{verb} {len(removed.objects)} objects, {len(removed.manifests)} manifests")
