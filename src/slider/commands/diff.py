"""``slider diff``: how a target differs between two plans, or two stores."""

import argparse
from collections import Counter
from pathlib import Path

from slider.artefacts.current import add_store_argument
from slider.artefacts.lineage import count, differences, find_target, recent_plans
from slider.artefacts.plan import Plan, plan_paths, read_plan
from slider.artefacts.store import ARTEFACTS, Store
from slider.core.errors import UserError

_SIDE = "latest, previous, digits of a plan in artefacts/plans, or the folder of another store"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("old", help=_SIDE)
    parser.add_argument("new", help="the same")
    parser.add_argument("--target", default="table1", help="default: table1")
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print the causes of the difference of a target in two plans; status 1 where there is one.

    Raises:
        UserError: there is no such plan, or no such target.
    """
    sides = arguments.old, arguments.new
    old_store, new_store = (_store(side, arguments.artefacts) for side in sides)
    old, new = _plan(sides[0], old_store), _plan(sides[1], new_store)
    target = find_target(find_target(arguments.target, new), old)
    causes = differences(old, new, target, (old_store, new_store))
    plural = "s" * (len(causes) > 1)
    print(f"{target}: {f'{len(causes)} cause{plural} of a difference' if causes else 'the same'}")
    for cause, jobs in causes.items():
        stages = Counter(job.stage for job in jobs)
        print(f"  {', '.join(count(stage, n) for stage, n in stages.items())}: {cause}")
    return 1 if causes else 0


def _store(side: str, default: Path) -> Store:
    if not Path(side).is_dir():
        return Store(default)
    inner = Path(side) / ARTEFACTS
    return Store(inner if inner.is_dir() else Path(side))


def _plan(side: str, store: Store) -> Plan:
    place = {"previous": 1}.get(side, 0)
    if side in ("latest", "previous") or Path(side).is_dir():
        plans = list(recent_plans(store))
        if place < len(plans):
            return plans[place]
    else:
        paths = [path for path in plan_paths(store.root / "plans") if path.stem.startswith(side)]
        if len(paths) == 1:
            return read_plan(paths[0])
    folder = store.root / "plans"
    raise UserError(f"expected a plan '{side}' in {folder}, found none: run `snakemake -n`")
