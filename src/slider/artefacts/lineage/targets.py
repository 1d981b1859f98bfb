"""What people call a result: a report, a target, a job's label, a recipe, a manifest, an object."""

import difflib
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from slider.artefacts.manifest import Manifest, Result, readable
from slider.artefacts.plan import JobSpec, Plan, plan_paths, read_plan
from slider.artefacts.store import ARTEFACTS, Store
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

    @cached_property
    def manifest(self) -> Manifest | None:
        """The job's manifest, if there is a readable one."""
        return readable(self.store.manifest_path(self.job.stage, self.job.recipe))

    @property
    def result(self) -> Result:
        """The result of a job that has one."""
        assert self.manifest is not None
        return self.manifest.result

    @property
    def object(self) -> str | None:
        """Digest of the result, if there is one."""
        return self.manifest.result.object if self.manifest else None

    @cached_property
    def facts(self) -> dict[str, Any]:
        """What is noted beside the result."""
        return self.store.facts(self.job.stage, self.job.recipe)

    @property
    def name(self) -> str:
        """The job's target, or else its label."""
        targets = (name for name, recipe in self.plan.targets.items() if recipe == self.job.recipe)
        return next(targets, self.job.label)

    @property
    def inputs(self) -> list["Found"]:
        """Jobs whose results the job needs."""
        return [Found(self.store, self.plan, job) for job in self.job.needs]


def known_plans(store: Store) -> Iterator[Plan]:
    """Readable plans of a store, the latest first."""
    for path in plan_paths(store.root / "plans"):
        with suppress(UserError):
            yield read_plan(path)


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
    plans = list(known_plans(store))
    if not plans:
        raise UserError(
            f"expected a plan in {store.root / 'plans'}, found none: `snakemake -n` writes one"
        )
    named = next(filter(None, (_named(text, plan) for plan in plans)), set())
    recipes = named or _by_file(text, store) or _by_digest(text, plans, store)
    if not recipes:
        raise UserError(f"expected {_EXPECTED}, found '{text}'; {_suggestions(text, plans[0])}")
    for plan in plans:
        meant = [job for recipe, job in plan.jobs.items() if recipe in recipes]
        if len(meant) > 1:
            raise UserError(f"'{text}' may be {_candidates(meant, plan)}: its recipe tells")
        if meant:
            return Found(store, plan, meant[0])
    raise UserError(f"expected a plan with '{text}', found none: its configuration is forgotten")


def _named(text: str, plan: Plan) -> set[str]:
    """Recipes of a target, a label, a stage or a command."""
    path = Path(text)
    for name in [text] if not path.suffix or os.path.isfile(text) else [text, path.stem]:
        if (target := ALIASES.get(name, name)) in plan.targets:
            return {plan.targets[target]}
    wanted, jobs = " ".join(text.split()).casefold(), plan.jobs.values()
    labelled = {job.recipe for job in jobs if job.label.casefold() == wanted}
    staged = {job.recipe for job in jobs if job.stage == text}
    return labelled or staged or {job.recipe for job in jobs if _is_commanded(job, text)}


def _is_commanded(job: JobSpec, text: str) -> bool:
    """Tell whether a job is that of a stage at a velocity, such as ``gait vx=0.6 vy=0``."""
    match = _COMMAND.fullmatch(text)
    if match is None or match[1] != job.stage or "command" not in job.section:
        return False
    wanted = dict(pair.split("=") for pair in match[2].split())
    command = job.section["command"]
    own = [*(command if isinstance(command, list) else [command]), 0.0, 0.0]
    with suppress(ValueError):
        asked = [float(wanted.get(name, 0.0)) for name in ("vx", "vy", "yaw_rate")]
        return all(abs(a - b) < 1e-9 for a, b in zip(own, asked, strict=False))
    return False


def _by_file(text: str, store: Store) -> set[str]:
    """Recipe of a manifest; recipes whose result has this very file."""
    if match := _MANIFEST.fullmatch(Path(text).name):
        return {match[1]}
    if not os.path.isfile(text):
        return set()
    found = store.mentioning(files.digest_file(Path(text)))
    if not found:
        raise UserError(
            f"expected {text} to be a file of a result in {store.root}, found none with its content"
        )
    return {manifest.recipe for manifest in found}


def _by_digest(text: str, plans: Sequence[Plan], store: Store) -> set[str]:
    """Recipes that begin with some digits, or else those of objects that do."""
    if not _DIGEST.fullmatch(text):
        return set()
    recipes = {recipe for plan in plans for recipe in plan.jobs if recipe.startswith(text)}
    if len(recipes) > 1:
        listed = ", ".join(sorted(recipes)[:_LISTED])
        raise UserError(f"'{text}' may be {listed}: more digits tell")
    found = () if recipes else store.mentioning(f'"{text}')
    return recipes or {m.recipe for m in found if m.result.object.startswith(text)}


def _candidates(jobs: Sequence[JobSpec], plan: Plan) -> str:
    """Jobs in words, each with the target that it is an input of."""
    texts = []
    for job in jobs[:_LISTED]:
        users = (n for n, target in plan.targets.items() if job in plan.jobs[target].needs)
        of = next((f" of {name}" for name in users), "")
        texts.append(f"{job.recipe[:SHORT]} ({job.label}{of})")
    return ", ".join([*texts, *[f"{len(jobs) - _LISTED} more"] * (len(jobs) > _LISTED)])


def _suggestions(text: str, plan: Plan) -> str:
    labels = dict.fromkeys(job.label for job in plan.jobs.values())
    close = difflib.get_close_matches(text, [*plan.targets, *labels], 3, 0.75)
    return f"did you mean {' or '.join(close)}?" if close else f"targets: {', '.join(plan.targets)}"
