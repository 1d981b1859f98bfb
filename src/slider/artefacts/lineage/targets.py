"""What people call a result: a report, a target, a job's label, a recipe, a manifest, an object."""

import difflib
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from slider.artefacts.plan import JobSpec, Plan, read_plan
from slider.artefacts.store import ARTEFACTS, Manifest, Store, parse_manifest
from slider.core import files
from slider.core.errors import UserError

SHORT = 12  # digits of a digest that people see
ALIASES = {"policy": "walking", "gait_library": "library", "index": "report"}
"""What people say for a target of another name."""
_EXPECTED = (
    "a report, a target, a job's label, a manifest, or 6 or more digits of a recipe or an object"
)
_DIGEST = re.compile(r"[0-9a-f]{6,64}")
_COMMAND = re.compile(r"(\w+)((?: (?:vx|vy|yaw_rate)=\S+)+)")
_MANIFEST = re.compile(r"([0-9a-f]{64})(\.run)?\.json")
_LISTED = 6  # candidates


@dataclass(frozen=True)
class Found:
    """A job of a plan, in the store that may hold its result."""

    store: Store
    plan: Plan
    job: JobSpec

    @property
    def manifest(self) -> Manifest | None:
        """The job's manifest, if there is a readable one."""
        return manifest_of(self.store, self.job)

    @property
    def name(self) -> str:
        """The job's target, or else its label."""
        targets = (name for name, recipe in self.plan.targets.items() if recipe == self.job.recipe)
        return next(targets, self.job.label)


@dataclass(frozen=True)
class Layout:
    """A file of a plan: its plain values, and the plan where that is needed."""

    path: Path
    values: Mapping[str, Any]

    @cached_property
    def plan(self) -> Plan:
        """The plan itself; rebuilding all recipes takes ten times as long as the values."""
        return read_plan(self.path)

    @property
    def jobs(self) -> Mapping[str, Mapping[str, Any]]:
        """Stage, label, section and inputs by recipe."""
        return self.values["jobs"]


def manifest_of(store: Store, job: JobSpec) -> Manifest | None:
    """Manifest of a job, if there is a readable one."""
    try:
        return store.read_manifest(job.stage, job.recipe)
    except UserError:
        return None


def layouts(store: Store) -> Iterator[Layout]:
    """Readable plans of a store, the latest first."""
    paths = (store.root / "plans").glob("*.json")
    for path in sorted(paths, key=lambda path: path.stat().st_mtime, reverse=True):
        try:
            values = files.read_json(path)
            known = all({*job} >= {"stage", "label", "section"} for job in values["jobs"].values())
            if known and isinstance(values["targets"], dict):
                yield Layout(path, values)
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            continue


def place(text: str, default: Path) -> tuple[Store, str]:
    """Store and name of ``path/to/artefacts:name``, or of a name in the default store."""
    folder, colon, name = text.rpartition(":")
    if not colon or not os.path.isdir(folder):
        return Store(default), text
    inner = Path(folder) / ARTEFACTS
    return Store(inner if inner.is_dir() else Path(folder)), name


def find(text: str, store: Store) -> Found:
    """The job that a person means, of the latest plan that has it.

    Raises:
        UserError: no plan has such a job, or several are meant.
    """
    known = list(layouts(store))
    if not known:
        raise UserError(
            f"expected a plan in {store.root / 'plans'}, found none: `snakemake -n` writes one"
        )
    ways = (_by_name, _by_file, _by_digest)
    recipes = next(filter(None, (way(text, known, store) for way in ways)), None)
    if not recipes:
        raise UserError(f"expected {_EXPECTED}, found '{text}'; {_suggestions(text, known[0])}")
    for layout in known:
        meant = [recipe for recipe in layout.jobs if recipe in recipes]
        if len(meant) > 1:
            raise UserError(f"'{text}' may be {_candidates(meant, layout)}")
        if meant:
            return Found(store, layout.plan, layout.plan.jobs[meant[0]])
    raise UserError(f"expected a plan with '{text}', found none: its configuration is forgotten")


def _by_name(text: str, known: Sequence[Layout], store: Store) -> set[str]:
    """Recipes of a target, a label, a stage or a command, in the latest plan that has such."""
    return next(filter(None, (_named(text, layout) for layout in known)), set())


def _named(text: str, layout: Layout) -> set[str]:
    targets = layout.values["targets"]
    path = Path(text)
    for name in [text] if not path.suffix or os.path.isfile(text) else [text, path.stem]:
        if (target := ALIASES.get(name, name)) in targets:
            return {targets[target]}
    wanted = " ".join(text.split()).casefold()
    labelled = {r for r, job in layout.jobs.items() if job["label"].casefold() == wanted}
    if labelled:
        return labelled
    found = {recipe for recipe, job in layout.jobs.items() if job["stage"] == text}
    return found or _commanded(text, layout)


def _commanded(text: str, layout: Layout) -> set[str]:
    """Jobs of a stage at a velocity, such as ``gait vx=0.6 vy=0``."""
    match = _COMMAND.fullmatch(text)
    if match is None:
        return set()
    wanted = dict(pair.split("=") for pair in match[2].split())
    try:
        velocity = [float(wanted.get(name, 0.0)) for name in ("vx", "vy", "yaw_rate")]
    except ValueError:
        return set()
    parts = layout.values["parts"]
    jobs = {r: job["section"] for r, job in layout.jobs.items() if job["stage"] == match[1]}
    commands = {r: parts[section["command"]] for r, section in jobs.items() if "command" in section}
    return {recipe for recipe, command in commands.items() if _same(command, velocity)}


def _same(command: Any, velocity: Sequence[float]) -> bool:
    own = command if isinstance(command, list) else [command]
    full = [*own, *[0.0] * (len(velocity) - len(own))]
    return all(abs(a - b) < 1e-9 for a, b in zip(full, velocity, strict=True))


def _by_file(text: str, known: Sequence[Layout], store: Store) -> set[str]:
    """Recipe of a manifest; recipes whose result has this very file."""
    path = Path(text)
    if match := _MANIFEST.fullmatch(path.name):
        return {match[1]}
    if not os.path.isfile(text):
        return set()
    digest = files.digest_file(path)
    found = _mentioning(digest, store)
    if not found:
        raise UserError(
            f"expected {text} to be a file of a result in {store.root}, found none with its content"
        )
    return {manifest.recipe for manifest in found}


def _by_digest(text: str, known: Sequence[Layout], store: Store) -> set[str]:
    """Recipes that begin with some digits, or else those of objects that do."""
    if not _DIGEST.fullmatch(text):
        return set()
    recipes = {recipe for layout in known for recipe in layout.jobs if recipe.startswith(text)}
    if len(recipes) > 1:
        listed = ", ".join(sorted(recipes)[:_LISTED])
        raise UserError(f"'{text}' may be {listed}: more digits tell")
    found = () if recipes else _mentioning(f'"{text}', store)
    return recipes or {m.recipe for m in found if m.result.object.startswith(text)}


def _mentioning(text: str, store: Store) -> list[Manifest]:
    paths = [path for path in store.manifests() if text in path.read_text(errors="replace")]
    found = []
    for path in paths:
        try:
            found.append(parse_manifest(path))
        except UserError:
            continue
    return found


def _candidates(recipes: Sequence[str], layout: Layout) -> str:
    """Jobs in words, each with the target that it is an input of."""
    texts = [_candidate(recipe, layout) for recipe in recipes[:_LISTED]]
    more = [f"{len(recipes) - _LISTED} more"] if len(recipes) > _LISTED else []
    return ", ".join([*texts, *more]) + ": its recipe tells"


def _candidate(recipe: str, layout: Layout) -> str:
    users = (
        name
        for name, target in layout.values["targets"].items()
        if any(recipe in group for group in layout.jobs[target]["inputs"].values())
    )
    user = next(users, None)
    of = f" of {user}" if user else ""
    return f"{recipe[:SHORT]} ({layout.jobs[recipe]['label']}{of})"


def _suggestions(text: str, layout: Layout) -> str:
    targets = list(layout.values["targets"])
    labels = list(dict.fromkeys(job["label"] for job in layout.jobs.values()))
    close = difflib.get_close_matches(text, [*targets, *labels], 3, 0.75)
    return f"did you mean {' or '.join(close)}?" if close else f"targets: {', '.join(targets)}"
