"""Where a report comes from: the job of the store that wrote it, and its facts."""

from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from slider.artefacts.manifest import Manifest, parse_manifest
from slider.artefacts.run_metadata import config_option, revision
from slider.artefacts.store import Store
from slider.core import files
from slider.core.machine import machine


def made(report: Path, store: Store) -> Manifest | None:
    """The job whose result has this very file, under whatever name; the first one that ended."""
    found = store.mentioning(files.digest_file(report))
    return min(found, key=lambda one: str(facts(one, store).get("ended", "")), default=None)


def ancestry(one: Manifest, store: Store) -> Iterator[Manifest]:
    """A result and all that it was made from, each once."""
    waiting, known = [one], {one.recipe}
    while waiting:
        current = waiting.pop()
        yield current
        for recipe in (r for recipes in current.inputs.values() for r in recipes):
            if recipe not in known:
                known.add(recipe)
                waiting += map(parse_manifest, store.root.glob(f"*/{recipe}.json"))


def facts(one: Manifest, store: Store) -> dict[str, Any]:
    """What is noted beside a result: commit, times, machine, overrides."""
    return store.facts(one.stage, one.recipe)


def line(report: Path, command: str, noted: Mapping[str, Any] | None) -> str:
    """What stands below a table: command, commit, date, machine.

    A report of which nothing is noted counts as made here, when the file was written.
    """
    noted = {**revision(), "ended": _written(report)} if noted is None else noted
    whole = command + config_option(str(noted.get("overrides", "")))
    date = str(noted.get("ended", "unknown"))[:10]
    return f"Made by `{whole}`, {_commit(noted)}, {date}, {noted.get('machine', machine())}."


def _written(report: Path) -> str:
    return datetime.fromtimestamp(report.stat().st_mtime, UTC).isoformat()


def _commit(facts: Mapping[str, Any]) -> str:
    if "commit" not in facts:
        return "commit unknown"
    changed = " with changes" if facts.get("dirty") == "true" else ""
    return f"commit `{facts['commit'][:8]}`{changed}"
