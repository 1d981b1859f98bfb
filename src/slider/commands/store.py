"""``slider store``: list, verify and clean the artefact store; push and pull results."""

import argparse
import statistics
import sys
import time

from slider.artefacts.current import add_store_argument, current_plan
from slider.artefacts.forecast import remembered
from slider.artefacts.maintenance import Removed, collect, summarise, verify
from slider.artefacts.plan import JobSpec
from slider.artefacts.remote import Remote
from slider.artefacts.sharing import pull, push
from slider.artefacts.store import Store
from slider.core.errors import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_store_argument(parser)
    actions = parser.add_subparsers(dest="action", required=True)
    actions.add_parser("ls", help="count manifests, objects and bytes of each stage")
    actions.add_parser("verify", help="rehash objects; drop what is corrupt or unreadable")
    gc = actions.add_parser("gc", help="remove what the latest plans do not reach")
    gc.add_argument("--keep", type=int, default=5, help="number of plans to keep (default: 5)")
    gc.add_argument("--dry-run", action="store_true", help="only say what would be removed")
    actions.add_parser("times", help="seconds per size of each kind of job")
    _add_travel(actions.add_parser("push", help="send results of the current plan to a remote"))
    _add_travel(actions.add_parser("pull", help="take results of the current plan from a remote"))
    actions.choices["push"].add_argument(
        "--verify", action="store_true", help="read what is there and replace what is damaged"
    )


def _add_travel(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("remote", help="a folder, sftp://host/path, s3://bucket/path or https://…")
    parser.add_argument("targets", nargs="*", help="names such as report (default: table1)")
    parser.add_argument("--all", action="store_true", help="all targets of the plan")


def run(arguments: argparse.Namespace) -> int:
    """Run one action; ``verify``, ``push`` and ``pull`` end with status 1 if they found damage."""
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
        return _times(store)
    if arguments.action in ("push", "pull"):
        return _travel(store, arguments)
    dry_run = arguments.dry_run
    _report("would remove" if dry_run else "removed", collect(store, arguments.keep, dry_run))
    return 0


def _travel(store: Store, arguments: argparse.Namespace) -> int:
    started, remote = time.monotonic(), Remote(arguments.remote)
    jobs = _jobs(store, arguments.targets, arguments.all)
    if arguments.action == "push":
        account = push(store, jobs, remote, arguments.verify)
    else:
        account = pull(store, jobs, remote)
    for line in account.damage:
        print(line, file=sys.stderr)
    way = "to" if arguments.action == "push" else "from"
    print(f"{arguments.action} {way} {remote.url}: {account} in {time.monotonic() - started:.1f} s")
    return int(bool(account.damage))


def _jobs(store: Store, targets: list[str], everything: bool) -> dict[str, JobSpec]:
    """Jobs of the current plan that some targets need, inputs first."""
    plan = current_plan(store)
    if plan is None:
        raise UserError("no plan yet: `snakemake -n` with your --config writes it")
    names = list(plan.targets) if everything else targets or ["table1"]
    for name in names:
        if name not in plan.targets:
            names = ", ".join(plan.targets)
            raise UserError(f"expected targets of the current plan ({names}), found {name}")
    return dict(plan.jobs_of(*names))


def _list(store: Store) -> int:
    print(f"{'stage':<14}{'manifests':>10}{'objects':>10}{'MB':>10}")
    for stage, (manifests, objects, size) in summarise(store).items():
        print(f"{stage:<14}{manifests:>10}{objects:>10}{size / 1e6:>10.2f}")
    return 0


def _times(store: Store) -> int:
    """Print what new clones tell the time left by: ``src/slider/artefacts/times.csv``."""
    stages = sorted({path.parent.name for path in store.manifests()})
    print("kind,rate")
    for kind, rates in remembered(store, stages).items():
        print(f"{kind},{statistics.median(rates):.4g}")
    return 0


def _report(verb: str, removed: Removed) -> None:
    for name in (*(f"object {digest}" for digest in removed.objects), *removed.manifests):
        print(f"{verb} {name}")
    print(f"{verb} {len(removed.objects)} objects, {len(removed.manifests)} manifests")
