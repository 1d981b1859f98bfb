"""Where a report comes from: the job of the store that wrote it, and its facts."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from slider.artefacts.circumstances import revision
from slider.artefacts.store import Manifest, Store, parse_manifest
from slider.core import files
from slider.core.machine import machine


@dataclass(frozen=True)
class Made:
    """A result of the store, and what is noted beside it: commit, times, machine, overrides."""

    manifest: Manifest
    facts: Mapping[str, Any]


def made(report: Path, store: Store) -> Made | None:
    """The job whose result has this very file, under whatever name; the first one that ended."""
    digest = files.digest_file(report)
    named = (path for path in store.manifests() if digest in path.read_text(encoding="utf-8"))
    found = [_read(path, store) for path in named]
    return min(found, key=lambda one: str(one.facts.get("ended", "")), default=None)


def ancestry(one: Made, store: Store) -> Iterator[Made]:
    """A result and all that it was made from, each once."""
    waiting, known = [one], {one.manifest.recipe}
    while waiting:
        current = waiting.pop()
        yield current
        for recipe in (r for recipes in current.manifest.inputs.values() for r in recipes):
            if recipe not in known:
                known.add(recipe)
                waiting += [_read(path, store) for path in store.root.glob(f"*/{recipe}.json")]


def _read(path: Path, store: Store) -> Made:
    manifest = parse_manifest(path)
    sidecar = store.sidecar_path(manifest.stage, manifest.recipe)
    return Made(manifest, files.read_json(sidecar) if sidecar.is_file() else {})


def line(report: Path, command: str, found: Made | None) -> str:
    """What stands below a table: command, commit, date, machine.

    A report that is in no store counts as made here, when the file was written.
    """
    facts = found.facts if found else {**revision(), "ended": _written(report)}
    hydra = facts.get("overrides", "")
    config = f" --config hydra='{hydra}'" if hydra else ""
    date = str(facts.get("ended", "unknown"))[:10]
    return (
        f"Made by `{command}{config}`, {_commit(facts)}, {date}, {facts.get('machine', machine())}."
    )


def _written(report: Path) -> str:
    return datetime.fromtimestamp(report.stat().st_mtime, UTC).isoformat()


def _commit(facts: Mapping[str, Any]) -> str:
    if "commit" not in facts:
        return "commit unknown"
    changed = " with changes" if facts.get("dirty") == "true" else ""
    return f"commit `{facts['commit'][:8]}`{changed}"
