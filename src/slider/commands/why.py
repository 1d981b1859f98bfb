"""``slider why``: what a target computes, and because of which change."""

import argparse
from collections import Counter

from slider.artefacts.current import add_store_argument, current_plan, find_target
from slider.artefacts.lineage import pending
from slider.artefacts.store import Store
from slider.core.errors import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("target", help="such as table1 or reports/table1.csv")
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print the jobs of the latest plan that lead to a target and have no result, by reason."""
    store = Store(arguments.artefacts)
    plan = current_plan(store)
    if plan is None:
        raise UserError(f"expected a plan in {store.root / 'plans'}, found none: `snakemake -n`")
    target = find_target(arguments.target, plan)
    jobs = pending(plan, target, store)
    print(f"{target}: {f'{len(jobs)} to compute' if jobs else 'nothing to compute'}")
    counts = Counter((job.stage, "; ".join(reasons)) for job, reasons in jobs)
    for (stage, reasons), number in counts.items():
        print(f"  {stage}{f' × {number}' if number > 1 else ''}: {reasons}")
