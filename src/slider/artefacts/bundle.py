"""A result with all that it came from, as a Workflow Run RO-Crate.

RO-Crate 1.1 and the profiles Process Run Crate and Workflow Run Crate 0.5
(https://w3id.org/ro/wfrun/workflow/0.5). The folder is a working copy of the project with a store
that holds what the result came from, so that all commands work in it.
"""

import shutil
import subprocess
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from rocrate.model import ContextEntity
from rocrate.rocrate import ROCrate

from slider.artefacts.manifest import Result
from slider.artefacts.plan import JobSpec, Plan, write_plan
from slider.artefacts.recipe import code_of
from slider.artefacts.store import ARTEFACTS, Store
from slider.core import files
from slider.core.errors import UserError

WORKFLOW = "Snakefile"
RESULTS = "results"
VERSION = "1.1"
PROFILE_VERSION = "0.5"
_PROFILES = {"process": "Process Run Crate", "workflow": "Workflow Run Crate"}
_TERMS = "https://w3id.org/ro/terms/workflow-run/context"
_CITATION = "CITATION.cff"


@dataclass(frozen=True)
class _Computed:
    """A job, its result, and what was noted beside it."""

    job: JobSpec
    result: Result
    facts: Mapping[str, Any]


def write_bundle(
    plan: Plan, store: Store, overrides: str, command: str, licence: str, out: Path
) -> int:
    """Write the targets of ``plan``, all in the store, to the empty folder ``out``.

    The present folder is the working copy.

    Args:
        plan: of what the bundle has.
        store: where the results are.
        overrides: of the configuration of the results.
        command: that leads to the results.
        licence: its URL, or a sentence.
        out: folder.

    Returns:
        Size of the results [bytes].

    Raises:
        UserError: a result is missing or damaged, or the source is no longer that of the plan.
    """
    _check_source(plan)
    jobs = {
        recipe: _Computed(
            job, store.checked(job.stage, recipe).result, store.facts(job.stage, recipe)
        )
        for recipe, job in plan.jobs.items()
    }
    names = _working_copy(out)
    _copy_store(jobs.values(), store, Store(out / ARTEFACTS))
    plan_path = write_plan(plan, out / ARTEFACTS / "plans")
    results = list(_copy_results(plan, jobs, store, out))
    crate = ROCrate(version=VERSION)
    crate.metadata.extra_contexts.append(_TERMS)
    _describe_project(crate, names, out, licence)
    whole = _run(crate, list(jobs.values()), overrides, command)
    whole.append_to(
        "object", _file(crate, plan_path, out, "What each job computes, with what settings")
    )
    whole["result"] = [_file(crate, path, out, text) for path, text in results]
    _describe_jobs(crate, jobs, out)
    crate.metadata.write(out)
    return sum(one.result.size for one in jobs.values())


def _check_source(plan: Plan) -> None:
    for code in {job.code.entry: job.code for job in plan.jobs.values()}.values():
        if code_of(code.entry).source != code.source:
            raise UserError(
                f"expected the source with which {code.entry} ran, found another: "
                "run the pipeline again"
            )


def _working_copy(out: Path) -> list[str]:
    """Copy what git tracks, as it is now; list it."""
    try:
        answer = subprocess.run(["git", "ls-files", "-z"], capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        raise UserError(f"expected a git working copy at {Path()}, found none") from None
    for name in filter(None, answer.stdout.decode().split("\0")):
        source, target = Path(name), out / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():  # a link to a folder, which an archive cannot hold
            shutil.copytree(source, target)
        elif source.exists():
            shutil.copy2(source, target)
    return files.list_files(out)


def _copy_store(jobs: Iterable[_Computed], store: Store, target: Store) -> None:
    for one in jobs:
        folder = target.object_folder(one.result.object)
        if not folder.exists():
            shutil.copytree(store.object_folder(one.result.object), folder)
        target.write_manifest(store.read_manifest(one.job.stage, one.job.recipe))
        files.write_json(target.sidecar_path(one.job.stage, one.job.recipe), one.facts)


def _copy_results(
    plan: Plan, jobs: Mapping[str, _Computed], store: Store, out: Path
) -> Iterator[tuple[Path, str]]:
    """Copy what people look for to folders of the targets' names; yield file and title."""
    wanted = {name: jobs[recipe] for name, recipe in plan.targets.items()}
    if policy := _policy(plan):
        wanted["policy"] = jobs[policy]
    for name, one in wanted.items():
        folder = store.object_folder(one.result.object)
        shutil.copytree(folder, out / RESULTS / name)
        for file in sorted(one.result.files):
            yield out / RESULTS / name / file, f"{name}: {file}"


def _policy(plan: Plan) -> str | None:
    """Recipe of the training whose policy Table 1, or else the first target with any, is about."""
    for name in sorted(plan.targets, key=lambda name: name != "table1"):
        jobs = [plan.jobs[plan.targets[name]]]
        for job in jobs:  # grows while it is read: a fine-tuning comes before its start
            if job.stage == "walking":
                return job.recipe
            jobs += job.needs
    return None


def _describe_project(crate: ROCrate, names: Sequence[str], out: Path, licence: str) -> None:
    citation = yaml.safe_load((out / _CITATION).read_text(encoding="utf-8"))
    crate.name, crate.description = citation["title"], citation["abstract"]
    crate.license = licence
    properties = {"name": citation["title"], "version": str(citation["version"])}
    workflow: Any = crate.add_workflow(
        dest_path=WORKFLOW, main=True, lang="snakemake", properties=properties
    )
    people = [_person(crate, person) for person in citation["authors"]]
    crate.root_dataset["author"] = workflow["creator"] = people
    for kind, name in _PROFILES.items():
        place = f"https://w3id.org/ro/wfrun/{kind}/{PROFILE_VERSION}"
        facts = {"name": name, "version": PROFILE_VERSION}
        crate.root_dataset.append_to("conformsTo", _add(crate, place, "CreativeWork", facts))
    for name in names:
        if name != WORKFLOW:
            _file(crate, out / name, out)


def _add(crate: ROCrate, place: str, kind: str, facts: Mapping[str, Any]) -> Any:
    return crate.add(ContextEntity(crate, place, {"@type": kind, **facts}))


def _person(crate: ROCrate, person: Mapping[str, str]) -> Any:
    name = person.get("name") or f"{person['given-names']} {person['family-names']}"
    kind = "Organization" if "name" in person else "Person"
    place = person.get("orcid") or f"#{name.replace(' ', '-')}"
    return _add(crate, place, kind, {"name": name})


def _file(crate: ROCrate, path: Path, out: Path, name: str = "") -> Any:
    place = path.relative_to(out).as_posix()
    facts = {"contentSize": path.stat().st_size, "sha256": files.digest_file(path)}
    return crate.add_file(dest_path=place, properties=facts | {"name": name or place})


def _run(crate: ROCrate, jobs: Sequence[_Computed], overrides: str, command: str) -> Any:
    """The action of the whole workflow, from the first job to the last, and its software."""
    workflow: Any = crate.mainEntity
    versions = {name: v for one in jobs for name, v in one.job.code.versions.items()}
    workflow["softwareRequirements"] = [
        _software(crate, f"#package-{name}", name, version)
        for name, version in sorted(versions.items())
    ]
    times = [one.facts[end] for one in jobs for end in ("started", "ended") if end in one.facts]
    settings = {"name": "overrides", "value": overrides or "none"}
    facts = {
        "name": "The whole run",
        "description": f"`{command}` leads to the results.",
        "instrument": workflow,
        "object": [_add(crate, "#overrides", "PropertyValue", settings)],
        **({"startTime": min(times), "endTime": max(times)} if times else {}),
    }
    run = _add(crate, "#run", "CreateAction", facts)
    crate.root_dataset["mentions"] = [run]
    return run


def _software(crate: ROCrate, place: str, name: str, version: str) -> Any:
    return _add(crate, place, "SoftwareApplication", {"name": name, "softwareVersion": version})


def _describe_jobs(crate: ROCrate, jobs: Mapping[str, _Computed], out: Path) -> None:
    """Add an action per job, from the objects of its inputs to its object."""
    store = Store(out / ARTEFACTS)
    folders = {
        recipe: _object(crate, one, store.object_folder(one.result.object), out)
        for recipe, one in jobs.items()
    }
    for recipe, one in jobs.items():
        code = one.job.code
        place = f"#{code.entry}"
        instrument = crate.get(place) or _software(crate, place, code.entry, code.source)
        needed = [folders[item.recipe] for item in one.job.needs]
        facts = {"name": one.job.label, "instrument": instrument}
        facts |= {"result": folders[recipe], "identifier": recipe}
        facts |= {"object": needed} if needed else {}
        known = {"startTime": "started", "endTime": "ended", "description": "machine"}
        facts |= {name: one.facts[key] for name, key in known.items() if key in one.facts}
        action = _add(crate, f"#{recipe}", "CreateAction", facts)
        crate.root_dataset.append_to("mentions", action)


def _object(crate: ROCrate, one: _Computed, folder: Path, out: Path) -> Any:
    place = f"{folder.relative_to(out).as_posix()}/"
    known = crate.get(place)
    if known is not None:  # another job has the same result
        return known
    facts = {"name": one.job.label, "identifier": one.result.object}
    dataset: Any = crate.add_dataset(dest_path=place, properties=facts)
    dataset["hasPart"] = [_file(crate, folder / name, out) for name in sorted(one.result.files)]
    return dataset
