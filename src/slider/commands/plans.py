"""``slider why`` and ``slider diff``: what a target must compute, and how two plans differ."""

import argparse
from collections import Counter
from pathlib import Path

from slider.artefacts.current import add_store_argument, current_plan, find_target, recent_plans
from slider.artefacts.lineage import differences, pending
from slider.artefacts.plan import Plan, plan_paths, read_plan
from slider.artefacts.store import ARTEFACTS, Store
from slider.core.errors import UserError

_SIDE = "latest, previous, digits of a plan in artefacts/plans, or the folder of another store"


def why_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of ``why``."""
    parser.add_argument("target", help="such as table1 or reports/table1.csv")
    add_store_argument(parser)


def why(arguments: argparse.Namespace) -> None:
    """Print the jobs of the latest plan that a target needs and that lack a result, by reason."""
    store = Store(arguments.artefacts)
    plan = current_plan(store)
    if plan is None:
        raise _no_plan("a plan", store)
    target = find_target(arguments.target, plan)
    jobs = pending(plan, target, store)
    print(f"{target}: {f'{len(jobs)} to compute' if jobs else 'nothing to compute'}")
    counts = Counter((job.stage, "; ".join(reasons)) for job, reasons in jobs)
    for (stage, reasons), number in counts.items():
        print(f"  {_count(stage, number)}: {reasons}")


def diff_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of ``diff``."""
    parser.add_argument("old", help=_SIDE)
    parser.add_argument("new", help="the same")
    parser.add_argument("--target", default="table1", help="default: table1")
    add_store_argument(parser)


def diff(arguments: argparse.Namespace) -> int:
    """Print why a target differs between two plans; status 1 if it does."""
    sides = arguments.old, arguments.new
    old_store, new_store = (_store(side, arguments.artefacts) for side in sides)
    old, new = _plan(sides[0], old_store), _plan(sides[1], new_store)
    target = find_target(find_target(arguments.target, new), old)
    causes = differences(old, new, target, (old_store, new_store))
    plural = "s" * (len(causes) > 1)
    print(f"{target}: {f'{len(causes)} cause{plural} of a difference' if causes else 'the same'}")
    for cause, jobs in causes.items():
        stages = Counter(job.stage for job in jobs)
        print(f"  {', '.join(_count(stage, n) for stage, n in stages.items())}: {cause}")
    return 1 if causes else 0


def _count(stage: str, number: int) -> str:
    return f"{stage} × {number}" if number > 1 else stage


def _store(side: str, default: Path) -> Store:
    if not Path(side).is_dir():
        return Store(default)
    inner = Path(side) / ARTEFACTS
    return Store(inner if inner.is_dir() else Path(side))


def _plan(side: str, store: Store) -> Plan:
    if side in ("latest", "previous") or Path(side).is_dir():
        plans = list(recent_plans(store))[side == "previous" :]
        if plans:
            return plans[0]
    else:
        paths = [path for path in plan_paths(store.root / "plans") if path.stem.startswith(side)]
        if len(paths) == 1:
            return read_plan(paths[0])
    raise _no_plan(f"a plan '{side}'", store)


def _no_plan(expected: str, store: Store) -> UserError:
    folder = store.root / "plans"
    return UserError(f"expected {expected} in {folder}, found none: run `snakemake -n`")
