"""Which modules a source digest covers, so that people learn what changed in a stage.

Beside a plan, ``sources/<digest>.json`` holds the digests of the modules and data files behind
each of its source digests. No recipe and no job depends on these files.
"""

from collections.abc import Mapping
from pathlib import Path

from slider.artefacts.plan import Plan
from slider.artefacts.recipe import SOURCE_ROOT
from slider.artefacts.source.closure import closure, digest_parts
from slider.artefacts.store import Store
from slider.core import files

Parts = Mapping[str, str]
"""Module, or path of a data file → digest."""


def note_sources(plan: Plan, store: Store, root: Path = SOURCE_ROOT) -> None:
    """Write the parts of the plan's source digests that are not there yet."""
    for entry, digest in sorted({(j.code.entry, j.code.source) for j in plan.jobs.values()}):
        if store.parts_path(digest).is_file():
            continue
        parts = closure(entry.partition(":")[0], root).parts
        if digest_parts(parts) == digest:  # else the source changed a moment ago
            files.write_json(store.parts_path(digest), parts)


def read_parts(path: Path) -> Parts:
    """Parts of the digest that a file is named after.

    Raises:
        OSError: there is none.
        ValueError: it is of another digest, or no table.
    """
    parts = files.read_json(path)
    if not isinstance(parts, dict) or digest_parts(parts) != path.stem:
        raise ValueError("expected the parts of the digest that the name says")
    return parts


def known_parts(store: Store, digest: str) -> Parts | None:
    """Parts of a source digest, if they were noted."""
    try:
        return read_parts(store.parts_path(digest))
    except (OSError, ValueError):
        return None
