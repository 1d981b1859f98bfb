"""The plan: every job that the current results need, with the complete input of each job.

Written when Snakemake reads the workflow, so that a job depends neither on Hydra nor on later
changes of the configuration files.
"""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from slider.artefacts.manifest import SCHEMA
from slider.artefacts.recipe import Code, Groups
from slider.core import files
from slider.core.errors import UserError, not_read

OF_MACHINE = ("numerics", "device", "precision", "folder")
"""Names in sections whose values depend on the machine that a job runs on."""


@dataclass(frozen=True)
class JobSpec:
    """One run of a stage: its part of the configuration (the section) and its inputs by name.

    The ``label`` is for display. A ``tracked`` job has its own run in MLflow.
    """

    stage: str
    label: str
    code: Code
    section: Mapping[str, Any]
    inputs: Mapping[str, Sequence["JobSpec"]] = field(default_factory=dict)
    tracked: bool = True

    @cached_property
    def recipe(self) -> str:
        """Digest of all attributes except ``label`` and ``tracked``."""
        return self.key(self.input_recipes)

    @property
    def input_recipes(self) -> dict[str, list[str]]:
        """Recipes of the inputs by name."""
        return {name: [job.recipe for job in jobs] for name, jobs in self.inputs.items()}

    @cached_property
    def plan_digests(self) -> dict[str, str]:
        """Digests of ``settings`` and of ``source`` with packages, of this job and all its inputs.

        Settings leave out :data:`OF_MACHINE`. The digest of the source depends on the version of
        Python, since syntax trees differ between versions.
        """
        code = [self.code.entry, self.code.source, self.code.versions]
        own = {"settings": [self.stage, _of_any_machine(self.section)], "source": code}
        inputs = {name: [job.plan_digests for job in jobs] for name, jobs in self.inputs.items()}
        return {
            part: files.digest_value(
                [value, {name: [job[part] for job in jobs] for name, jobs in inputs.items()}]
            )
            for part, value in own.items()
        }

    @property
    def needs(self) -> list["JobSpec"]:
        """All inputs, in their order."""
        return [job for jobs in self.inputs.values() for job in jobs]

    def key(self, inputs: Groups) -> str:
        """The recipe, given the recipes of the inputs; the index key, given their objects.

        Versions of this project with another manifest schema have different recipes.
        """
        code = [self.code.entry, self.code.source, self.code.versions]
        groups = {name: list(digests) for name, digests in inputs.items()}
        return files.digest_value([SCHEMA, self.stage, self.section, *code, groups])


def _of_any_machine(values: Any) -> Any:
    if isinstance(values, Mapping):
        return {n: _of_any_machine(value) for n, value in values.items() if n not in OF_MACHINE}
    return values


@dataclass(frozen=True)
class Plan:
    """Jobs by recipe in topological order, inputs first, and the recipe of each named target."""

    jobs: Mapping[str, JobSpec]
    targets: Mapping[str, str]

    def jobs_of(self, *targets: str) -> Mapping[str, JobSpec]:
        """Jobs that the given targets need, inputs first."""
        return build_plan({name: self.jobs[self.targets[name]] for name in targets}).jobs


def build_plan(targets: Mapping[str, JobSpec]) -> Plan:
    """Collect the jobs that the targets need."""
    jobs: dict[str, JobSpec] = {}

    def visit(job: JobSpec) -> None:
        if job.recipe in jobs:
            return
        for item in job.needs:
            visit(item)
        jobs[job.recipe] = job

    for target in targets.values():
        visit(target)
    return Plan(jobs, {name: job.recipe for name, job in targets.items()})


def plan_path(plan: Plan, folder: Path) -> Path:
    """File of a plan, named by its content."""
    return folder / f"{files.digest_value(_to_values(plan))}.json"


def plan_paths(folder: Path) -> list[Path]:
    """Files of plans, the latest first."""
    paths = (path for path in files.entries(folder) if path.suffix == ".json")
    return sorted(paths, key=lambda path: path.stat().st_mtime, reverse=True)


def write_plan(plan: Plan, folder: Path) -> Path:
    """Write a plan under the digest of its content, unless it is intact; make it the latest."""
    text, path = f"{files.canonical(_to_values(plan))}\n", plan_path(plan, folder)
    if not path.is_file() or path.read_bytes() != text.encode():
        files.write_atomic(path, text)
    os.utime(path)
    return path


def read_plan(path: Path) -> Plan:
    """Read a plan; recipes are read from the file, not computed again.

    Raises:
        UserError: the file is missing, does not match its name's digest, or has another format.
        NotReadError: it cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8").removesuffix("\n")
        if files.digest_text(text) == path.stem:
            return _from_values(json.loads(text))
    except (FileNotFoundError, ValueError, KeyError, TypeError, AttributeError):
        pass
    except OSError as error:
        raise not_read(error, path) from None
    raise UserError(f"expected a plan, found none at {path}")


def _to_values(plan: Plan) -> dict[str, Any]:
    """Plain values; equal parts of sections are stored once, since gaits share most of theirs."""
    parts, codes, jobs = {}, {}, {}
    for recipe, job in plan.jobs.items():
        names = {name: files.digest_value(value)[:16] for name, value in job.section.items()}
        parts |= {part: job.section[name] for name, part in names.items()}
        codes[job.code.entry] = job.code
        jobs[recipe] = {
            "stage": job.stage,
            "label": job.label,
            "code": job.code.entry,
            "section": names,
            "inputs": job.input_recipes,
            "tracked": job.tracked,
        }
    codes = {entry: asdict(code) for entry, code in codes.items()}
    return {"targets": dict(plan.targets), "codes": codes, "parts": parts, "jobs": jobs}


def _from_values(values: Mapping[str, Any]) -> Plan:
    codes = {entry: Code(**code) for entry, code in values["codes"].items()}
    jobs: dict[str, JobSpec] = {}
    for recipe, job in values["jobs"].items():
        section = {name: values["parts"][part] for name, part in job["section"].items()}
        inputs = {name: [jobs[item] for item in items] for name, items in job["inputs"].items()}
        given = {"code": codes[job["code"]], "section": section, "inputs": inputs}
        jobs[recipe] = JobSpec(**job | given)
        vars(jobs[recipe])["recipe"] = recipe  # computing all recipes takes most of the time
    return Plan(jobs, values["targets"])
