"""Reports are copies out of the store, redone whenever they differ from the current plan's."""

from collections.abc import Sequence
from pathlib import Path

from slider.artefacts.manifest import parse_manifest
from slider.artefacts.plan import Plan
from slider.artefacts.store import Store
from slider.core import files
from slider.core.errors import UserError


def marker_path(store: Store, target: str) -> Path:
    """Small file that changes whenever a report must be copied again."""
    return store.root / "current" / target


def refresh_marker(store: Store, plan: Plan, target: str, reports: Sequence[Path]) -> None:
    """Make reports look outdated exactly when they are not what the current plan says.

    The file names the plan's recipe. Where a report on disk is another one all the same (edited
    by hand, or the store was cleaned), the reason is appended: Snakemake compares the content of
    small inputs, so a new modification time alone would not do.
    """
    recipe = plan.targets[target]
    path = marker_path(store, target)
    found = path.read_text("utf-8", "replace").split() if path.is_file() else []
    manifest = store.manifest_path(plan.jobs[recipe].stage, recipe)
    differences = (_difference(manifest, report) for report in reports)
    reason = next((difference for difference in differences if difference), None)
    if reason is None and found[:1] == [recipe]:
        return
    wanted = [recipe, reason] if reason else [recipe]
    if found != wanted:
        files.write_atomic(path, "\n".join(wanted) + "\n")


def _difference(manifest: Path, report: Path) -> str | None:
    """One word that tells how the report differs from its manifest's, or nothing."""
    if not report.is_file():
        return None  # Snakemake sees that itself
    try:
        expected = parse_manifest(manifest).result.files[report.name]["sha256"]
    except (UserError, KeyError):
        return "unknown"
    found = files.digest_file(report)
    return None if found == expected else found
