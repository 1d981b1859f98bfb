"""The plan: every job that leads to the current results, with all that a job needs to know.

Written when the workflow is read, so that a job depends neither on Hydra nor on what happens to
the configuration files later.
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

OF_MACHINE = ("numerics", "device", "precision")
"""Names in sections whose values belong to the machine that a job runs on."""


@dataclass(frozen=True)
class JobSpec:
    """One stage with its own part of the configuration, the section, and its inputs by name.

    The ``label`` is for people. A ``tracked`` job is a run of its own in MLflow.
    """

    stage: str
    label: str
    code: Code
    section: Mapping[str, Any]
    inputs: Mapping[str, Sequence["JobSpec"]] = field(default_factory=dict)
    tracked: bool = True

    @cached_property
    def recipe(self) -> str:
        """Digest of all attributes but ``label`` and ``tracked``."""
        return self.key(self.input_recipes)

    @property
    def input_recipes(self) -> dict[str, list[str]]:
        """Recipes of the inputs by name."""
        return {name: [job.recipe for job in jobs] for name, jobs in self.inputs.items()}

    @cached_property
    def plan_digests(self) -> dict[str, str]:
        """Digests of the ``settings`` and of the ``source`` with packages, of all jobs up to here.

        Settings have none of :data:`OF_MACHINE`. The source is that of one version of Python,
        since syntax trees differ.
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
        """From the recipes of the inputs the recipe; from their objects the key of the index.

        Versions of this project with other manifests have other recipes, and keep theirs.
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
    """Jobs by recipe, inputs before those who use them, and the recipe of each named target."""

    jobs: Mapping[str, JobSpec]
    targets: Mapping[str, str]

    def jobs_of(self, *targets: str) -> Mapping[str, JobSpec]:
        """Jobs that some targets need, inputs first."""
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
    """Write a plan under the digest of its content, if it is not there whole, as the latest."""
    text, path = f"{files.canonical(_to_values(plan))}\n", plan_path(plan, folder)
    if not path.is_file() or path.read_bytes() != text.encode():
        files.write_atomic(path, text)
    os.utime(path)
    return path


def read_plan(path: Path) -> Plan:
    """Read a plan; its recipes are those with which it was laid out.

    Raises:
        UserError: the file is missing, is not the plan that its name says, or of another version.
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
    """Plain values. Parts of sections are digested and stored once: gaits share most of theirs."""
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
        vars(jobs[recipe])["recipe"] = recipe  # to compute them all takes most of the time
    return Plan(jobs, values["targets"])
