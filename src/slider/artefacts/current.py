"""Plans of a store, and the results of the current one: that which Snakemake laid out last."""

import argparse
import difflib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from slider.artefacts.manifest import Manifest
from slider.artefacts.plan import JobSpec, Plan, plan_paths, read_plan
from slider.artefacts.store import ARTEFACTS, Store
from slider.core.errors import UserError

ALIASES = {"policy": "walking", "gait_library": "library", "index": "report"}
"""Names of reports whose target has another name."""


def add_store_argument(parser: argparse.ArgumentParser) -> None:
    """Declare the argument with the folder of the store."""
    parser.add_argument(
        "--artefacts", type=Path, default=Path(ARTEFACTS), help="folder (default: artefacts)"
    )


def current_plan(store: Store) -> Plan | None:
    """The plan that was laid out last, if there is any.

    Raises:
        UserError: it cannot be read.
    """
    plans = plan_paths(store.root / "plans")
    return read_plan(plans[0]) if plans else None


def recent_plans(store: Store) -> Iterator[Plan]:
    """Readable plans of a store, the latest first."""
    for path in plan_paths(store.root / "plans"):
        with suppress(UserError):
            yield read_plan(path)


def find_target(text: str, plan: Plan) -> str:
    """Name of the target that a person means: itself, a report of it or an alias.

    Raises:
        UserError: the plan has no such target.
    """
    for name in (text, Path(text).stem):
        if (target := ALIASES.get(name, name)) in plan.targets:
            return target
    close = difflib.get_close_matches(text, plan.targets, 1, 0.6)
    hint = f"did you mean {close[0]}?" if close else f"targets: {', '.join(plan.targets)}"
    raise UserError(f"expected a target or a report of it, found '{text}'; {hint}")


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
