"""Plans of a store, and results of the current plan: the one that Snakemake created last."""

import argparse
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from slider.artefacts.plan import JobSpec, Plan, plan_paths, read_plan
from slider.artefacts.store import ARTEFACTS, Store
from slider.core.errors import UserError

ALIASES = {"policy": "policy_export", "gait_library": "library", "index": "report"}
ALIASES |= {"gait_quality": "table1", "tradeoff": "table1", "gauge_cells": "gauge"}
"""Report name → target name, where the two differ."""


def add_store_argument(parser: argparse.ArgumentParser) -> None:
    """Declare the argument with the folder of the store."""
    parser.add_argument(
        "--artefacts", type=Path, default=Path(ARTEFACTS), help="folder (default: artefacts)"
    )


def current_plan(store: Store) -> Plan | None:
    """The plan that was created last, if there is any."""
    return next(recent_plans(store), None)


def recent_plans(store: Store) -> Iterator[Plan]:
    """Readable plans of a store, the latest first."""
    for path in plan_paths(store.root / "plans"):
        with suppress(UserError):
            yield read_plan(path)


def find_target(text: str, plan: Plan) -> str:
    """Name of a target given by its name, a report file of it or an alias.

    Raises:
        UserError: the plan has no such target.
    """
    stem = Path(text).stem
    for name in (text, stem, stem.removesuffix("_runs").removesuffix("_curves")):
        if (target := ALIASES.get(name, name)) in plan.targets:
            return target
    targets = ", ".join(plan.targets)
    raise UserError(f"expected a target or a report of it, found '{text}'; targets: {targets}")


def current_result(store: Store, target: str, command: str) -> tuple[JobSpec, Path]:
    """Job of a named target of the current plan and the folder of its object.

    Raises:
        UserError: there is no intact result; the message names the ``command`` that computes it.
    """
    plan = current_plan(store)
    job = plan.jobs[plan.targets[target]] if plan and target in plan.targets else None
    manifest = store.verify(job.stage, job.recipe) if job else None
    if job is None or manifest is None:
        raise UserError(
            f"no {target} of the current configuration yet, that of the last run or dry run of "
            f"Snakemake; make it with `{command}` and the same --config"
        )
    return job, store.object_folder(manifest.result.object)


def current_folder(store: Store, target: str, command: str) -> Path:
    """Object folder of a named target of the current plan; see ``current_result``."""
    return current_result(store, target, command)[1]
