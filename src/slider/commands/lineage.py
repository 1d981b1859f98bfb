"""``slider lineage``: what a result was made from, how two differ, why one would be computed."""

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from slider.artefacts.current import add_store_argument
from slider.artefacts.lineage import text
from slider.artefacts.lineage.ancestry import everything
from slider.artefacts.lineage.compare import Difference, compare
from slider.artefacts.lineage.outlines import outlines
from slider.artefacts.lineage.pending import Pending, last_result, namesake, pending
from slider.artefacts.lineage.targets import SHORT, Found, find, known_plans, place
from slider.artefacts.store import Store
from slider.core.errors import UserError

_DEFAULT = "table1"
_TARGET = "report, target, job label, recipe, manifest or object; of another store as FOLDER:TARGET"
_SIDE = f"{_TARGET}; or overrides, such as 'train.walking.seed=2', '' for none"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="what a result was made from, when, where, how long")
    diff = actions.add_parser("diff", help="why two differ; status 0 same, 1 different, 2 unknown")
    why = actions.add_parser("why", help="what would be computed, because of which change")
    for action in (show, why):
        action.add_argument("target", help=_TARGET)
    why.add_argument("overrides", nargs="*", help="as after --config hydra= (default: none)")
    for side in ("a", "b"):
        diff.add_argument(side, help=_SIDE)
    diff.add_argument("--target", help=f"what to compare of two overrides (default: {_DEFAULT})")
    for action in (show, diff, why):
        action.add_argument("--json", action="store_true", help="everything, for programs")
        add_store_argument(action)


def run(arguments: argparse.Namespace) -> int:
    """Run one action; only ``diff`` has a status other than 0 for an answer."""
    if arguments.action == "show":
        found = _find(arguments.target, arguments)
        _print(arguments.json, lambda: everything(found), text.shown(found))
        return 0
    if arguments.action == "why":
        _why(arguments)
        return 0
    try:
        return _diff(arguments)
    except UserError as error:
        print(f"slider: {error}", file=sys.stderr)
        return 2


def _find(name: str, arguments: argparse.Namespace) -> Found:
    store, inner = place(name, arguments.artefacts)
    return find(inner, store)


def _print(as_json: bool, values: Callable[[], object], lines: Iterable[str]) -> None:
    print(json.dumps(values(), indent=1, ensure_ascii=False) if as_json else "\n".join(lines))


def _why(arguments: argparse.Namespace) -> None:
    store, target = place(arguments.target, arguments.artefacts)
    overrides = " ".join(item.removeprefix("hydra=") for item in arguments.overrides)
    with outlines([overrides], target) as (outline,):
        wanted = _wanted(target, outline, store)
        last = last_result(wanted, store)
        jobs = pending(wanted, store, last)
    values = {
        "name": wanted.name,
        "last": last.job.recipe if last else None,
        **wanted.job.names,
        "jobs": [_waiting(one) for one in jobs],
    }
    _print(arguments.json, lambda: values, _reasons(wanted, jobs))


def _reasons(wanted: Found, jobs: Sequence[Pending]) -> Iterator[str]:
    if not jobs:
        yield f"{wanted.name}: nothing to compute"
        return
    reused = sum(one.reused for one in jobs)
    yield f"{wanted.name}: {len(jobs) - reused} to compute" + f", {reused} to reuse" * bool(reused)
    yield from text.waiting(jobs)


def _wanted(target: str, outline: Store, store: Store) -> Found:
    """The job of a name in a laid-out plan, also where only a result of the store has the name."""
    name = Path(target).stem if Path(target).suffix else target
    try:
        return find(name, outline)
    except UserError as error:
        try:
            there = find(target, store)
        except UserError:
            raise error from None
        return _same(there, outline)


def _same(there: Found, outline: Store) -> Found:
    plan = next(known_plans(outline))
    job = namesake(there, plan)
    if job is None:
        raise UserError(f"expected a configuration with {there.name}, found one without")
    return Found(outline, plan, job)


def _diff(arguments: argparse.Namespace) -> int:
    names = [arguments.a, arguments.b]
    asked = [name for name in names if _is_overrides(name)]
    stored = [_find(name, arguments) for name in names if name not in asked]
    target = arguments.target or (stored[0].name if stored else _DEFAULT)
    with outlines(asked, target) as laid_out:
        laid = [
            _same(stored[0], one) if stored else _wanted(target, one, Store(arguments.artefacts))
            for one in laid_out
        ]
        results = [Found(Store(arguments.artefacts), one.plan, one.job) for one in laid]
        sides = iter(stored), iter(results)
        old, new = (next(sides[name in asked]) for name in names)
        differences = compare(old, new)
    objects = [old.object, new.object]
    alike = None if None in objects else objects[0] == objects[1]
    same = old.job.recipe == new.job.recipe and not differences if alike is None else alike
    values = {
        "same": same,
        "recipes": [one.job.recipe for one in (old, new)],
        "objects": objects,
        "differences": [
            asdict(one.cause) | {"jobs": [job.names for job in one.jobs]} for one in differences
        ],
    }
    _print(arguments.json, lambda: values, _verdict(old, new, alike, differences))
    return 0 if same else 1


def _verdict(
    old: Found, new: Found, alike: bool | None, differences: Sequence[Difference]
) -> Iterator[str]:
    recipes = list(dict.fromkeys(one.job.recipe[:SHORT] for one in (old, new)))
    result = {True: "the same result", False: "different results", None: "not both computed"}[alike]
    yield f"{new.name}: recipe{'s' * (len(recipes) - 1)} {' and '.join(recipes)}, {result}"
    yield from text.differing(differences)


def _waiting(one: Pending) -> dict[str, Any]:
    causes = [asdict(cause) for cause in one.causes]
    reasons = {"causes": causes, "inputs": one.inputs, "state": one.state, "reused": one.reused}
    return one.job.names | reasons


def _is_overrides(name: str) -> bool:
    words = name.split()
    return not os.path.exists(name) and all("=" in w or w[0] == "~" for w in words)
