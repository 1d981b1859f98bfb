"""``slider why``: what a target would compute, and because of which change."""

import argparse
from collections import Counter

from slider.artefacts.current import add_store_argument, current_plan
from slider.artefacts.lineage import count, find_target, pending
from slider.artefacts.store import Store
from slider.core.errors import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("target", help="such as table1 or reports/table1.csv")
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print the jobs of the latest plan that lead to a target and have no result, by reason.

    Raises:
        UserError: there is no plan, or no such target.
    """
    store = Store(arguments.artefacts)
    plan = current_plan(store)
    if plan is None:
        folder = store.root / "plans"
        raise UserError(f"expected a plan in {folder}, found none: run `snakemake -n`")
    target = find_target(arguments.target, plan)
    jobs = pending(plan, target, store)
    print(f"{target}: {f'{len(jobs)} to compute' if jobs else 'nothing to compute'}")
    counts = Counter((job.stage, "; ".join(reasons)) for job, reasons in jobs)
    for (stage, reasons), number in counts.items():
        print(f"  {count(stage, number)}: {reasons}")
