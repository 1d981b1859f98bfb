"""The results of the plan that Snakemake laid out last, for people and their commands."""

import argparse
from pathlib import Path

from slider.artefacts.manifest import Manifest
from slider.artefacts.plan import JobSpec, Plan, plan_paths, read_plan
from slider.artefacts.store import ARTEFACTS, Store
from slider.core.errors import UserError


def add_store_argument(parser: argparse.ArgumentParser) -> None:
    """Declare the argument that says where the store is."""
    parser.add_argument(
        "--artefacts", type=Path, default=Path(ARTEFACTS), help="folder (default: artefacts)"
    )


def current_plan(store: Store) -> Plan | None:
    """The plan that was laid out last, if there is any."""
    plans = plan_paths(store.root / "plans")
    return read_plan(plans[0]) if plans else None


def current_result(store: Store, target: str, command: str) -> tuple[JobSpec, Manifest]:
    """Job and manifest of a named target of the current plan.

    Raises:
        UserError: it has not been computed; names the ``command`` that does.
    """
    plan = current_plan(store)
    recipe = plan.targets.get(target) if plan else None
    job = plan.jobs[recipe] if plan and recipe else None
    if job is None or not store.manifest_path(job.stage, job.recipe).is_file():
        raise UserError(
            f"no {target} of the current configuration yet, that of the last run or dry run of "
            f"Snakemake; make it with `{command}` and the same --config"
        )
    return job, store.read_manifest(job.stage, job.recipe)


def current_folder(store: Store, target: str, command: str) -> Path:
    """Object folder of a named target of the current plan; see ``current_result``.

    Raises:
        UserError: it has not been computed, or its object is gone or damaged.
    """
    digest = current_result(store, target, command)[1].result.object
    if not store.is_whole(digest):
        state = "damaged" if store.object_folder(digest).is_dir() else "gone from the store"
        raise UserError(f"the {target} is {state}; make it again with `{command}`")
    return store.object_folder(digest)
