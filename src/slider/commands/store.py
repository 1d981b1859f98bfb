"""``slider store``: verify and clean the artefact store; push and pull results."""

import argparse
import statistics
import sys
import time

from slider.artefacts.current import add_store_argument, current_plan
from slider.artefacts.forecast import computed, known_rates
from slider.artefacts.maintenance import collect, verify
from slider.artefacts.remote import Remote
from slider.artefacts.store import Store
from slider.artefacts.transfer import pull, push
from slider.core.errors import UserError, one_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_store_argument(parser)
    actions = parser.add_subparsers(dest="action", required=True)
    actions.add_parser("verify", help="rehash objects; drop manifests without an intact one")
    gc = actions.add_parser("gc", help="remove results that the latest plans do not refer to")
    gc.add_argument("--keep", type=int, default=5, help="number of plans to keep (default: 5)")
    gc.add_argument("--dry-run", action="store_true", help="only say what would be removed")
    actions.add_parser("times", help="seconds per size, jobs and processor seconds by kind")
    push = actions.add_parser("push", help="send results of the current plan to a remote")
    pull = actions.add_parser("pull", help="take results of the current plan from a remote")
    remote = "a folder, sftp://host/path, s3://bucket/path or https://…"
    for action in (push, pull):
        action.add_argument("remote", help=remote)
        action.add_argument("targets", nargs="*", help="names such as report (default: table1)")
        action.add_argument("--all", action="store_true", help="all targets of the plan")
    push.add_argument("--force", action="store_true", help="replace what is there")


def run(arguments: argparse.Namespace) -> int:
    """Run one action; ``verify``, ``push`` and ``pull`` return status 1 if they found damage."""
    if not arguments.artefacts.is_dir():
        raise UserError(f"expected the artefact store, found none at {arguments.artefacts}")
    store, action = Store(arguments.artefacts), arguments.action
    if action in ("push", "pull"):
        return _travel(store, arguments)
    if action == "verify":
        lines = verify(store)
        print("\n".join([*lines, f"dropped {len(lines)} manifests"]))
        return int(bool(lines))
    elif action == "times":  # the content of src/slider/artefacts/times.csv
        print("kind,rate,jobs,cpu_s")
        stages = sorted({path.parent.name for path in store.manifests()})
        jobs = computed(store, stages)
        for kind, rates in known_rates(store, stages).items():
            spent = [seconds for seconds, _ in jobs.get(kind, ())]
            print(f"{kind},{statistics.median(rates):.4g},{len(spent)},{sum(spent):.1f}")
    else:
        removed = collect(store, arguments.keep, arguments.dry_run)
        verb = "would remove" if arguments.dry_run else "removed"
        for name in removed:
            print(f"{verb} {name}")
        print(f"{verb} {len(removed)} objects and manifests")
    return 0


def _travel(store: Store, arguments: argparse.Namespace) -> int:
    """Push or pull the results that some targets of the current plan need."""
    started, remote = time.monotonic(), Remote(arguments.remote)
    plan = current_plan(store)
    if plan is None:
        raise UserError("no plan yet: `snakemake -n` with your --config writes it")
    names = list(plan.targets) if arguments.all else arguments.targets or ["table1"]
    for name in names:
        one_of("target", name, plan.targets)
    jobs = dict(plan.jobs_of(*names))
    if arguments.action == "push":
        report, way = push(store, jobs, remote, arguments.force), "to"
    else:
        report, way = pull(store, jobs, remote), "from"
    for line in report.damage:
        print(line, file=sys.stderr)
    print(f"{arguments.action} {way} {remote.url}: {report} in {time.monotonic() - started:.1f} s")
    return int(bool(report.damage))
