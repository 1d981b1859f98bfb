"""A result with all that it came from, as a Workflow Run RO-Crate.

RO-Crate 1.1 and the profiles Process Run Crate and Workflow Run Crate 0.5
(https://w3id.org/ro/wfrun/workflow/0.5). The folder is a working copy of the project with a store
that holds what the result came from, so that all commands work in it.
"""

import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from rocrate.model import ContextEntity
from rocrate.rocrate import ROCrate

from slider.artefacts.manifest import Manifest
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


class _Computed(NamedTuple):
    """A job, its manifest, and what was noted beside it."""

    job: JobSpec
    manifest: Manifest
    facts: Mapping[str, Any]


def write_bundle(
    plan: Plan, store: Store, overrides: str, command: str, licence: str, out: Path
) -> int:
    """Write the targets of ``plan``, all in the store, to the empty folder ``out``.

    The present folder is the working copy; ``command``, with the ``overrides``, leads to the
    results; ``licence`` is a URL or a sentence. Returns the size of the results [bytes].

    Raises:
        UserError: a result is missing or damaged, or the source is no longer that of the plan.
    """
    for code in {job.code.entry: job.code for job in plan.jobs.values()}.values():
        if code_of(code.entry).source != code.source:
            raise UserError(
                f"expected the source with which {code.entry} ran, found another: "
                "run the pipeline again"
            )
    jobs = {
        recipe: _Computed(job, store.checked(job.stage, recipe), store.facts(job.stage, recipe))
        for recipe, job in plan.jobs.items()
    }
    names = _working_copy(out)
    target = Store(out / ARTEFACTS)
    for job, manifest, facts in jobs.values():
        digest = manifest.result.object
        if not target.object_folder(digest).exists():
            shutil.copytree(store.object_folder(digest), target.object_folder(digest))
        target.write_manifest(manifest)
        files.write_json(target.sidecar_path(job.stage, job.recipe), facts)
    plan_path = write_plan(plan, target.root / "plans")
    description = _Description(ROCrate(version=VERSION), out)
    description.add_project(names, licence)
    run = description.add_run(list(jobs.values()), overrides, command)
    text = "What each job computes, with what settings"
    run.append_to("object", description.file(plan_path, text))
    run["result"] = [
        description.file(path, text) for path, text in _copy_results(plan, jobs, store, out)
    ]
    description.add_jobs(jobs)
    description.crate.metadata.write(out)
    return sum(computed.manifest.result.size for computed in jobs.values())


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


def _copy_results(
    plan: Plan, jobs: Mapping[str, _Computed], store: Store, out: Path
) -> Iterator[tuple[Path, str]]:
    """Copy what people look for to folders of the targets' names; yield file and title.

    The policy is that of Table 1, or else of the first target with any.
    """
    recipes = dict(plan.targets)
    waiting = [plan.jobs[recipes[name]] for name in sorted(recipes, key=lambda n: n != "table1")]
    while waiting and "policy" not in recipes:
        job = waiting.pop(0)
        waiting = [*job.needs, *waiting]  # a fine-tuning comes before its start
        if job.stage == "walking":
            recipes["policy"] = job.recipe
    for name, recipe in recipes.items():
        result = jobs[recipe].manifest.result
        shutil.copytree(store.object_folder(result.object), out / RESULTS / name)
        for file in sorted(result.files):
            yield out / RESULTS / name / file, f"{name}: {file}"


@dataclass(frozen=True)
class _Description:
    """Metadata of the files in the folder ``out``."""

    crate: ROCrate
    out: Path

    def entity(self, place: str, kind: str, **facts: Any) -> Any:
        """The entity at a place, added with some facts if it is not there."""
        new = ContextEntity(self.crate, place, {"@type": kind, **facts})
        return self.crate.get(place) or self.crate.add(new)

    def file(self, path: Path, name: str = "") -> Any:
        """Add a file with size and digest."""
        place = path.relative_to(self.out).as_posix()
        facts = {"contentSize": path.stat().st_size, "sha256": files.digest_file(path)}
        return self.crate.add_file(dest_path=place, properties=facts | {"name": name or place})

    def software(self, place: str, name: str, version: str) -> Any:
        """A package or the entry point of a stage."""
        return self.entity(place, "SoftwareApplication", name=name, softwareVersion=version)

    def add_project(self, names: Sequence[str], licence: str) -> None:
        """Describe the working copy: title, people, workflow, profiles, files."""
        citation = yaml.safe_load((self.out / _CITATION).read_text(encoding="utf-8"))
        crate, title = self.crate, citation["title"]
        crate.metadata.extra_contexts.append(_TERMS)
        crate.name, crate.description, crate.license = title, citation["abstract"], licence
        properties = {"name": title, "version": str(citation["version"])}
        workflow: Any = crate.add_workflow(
            dest_path=WORKFLOW, main=True, lang="snakemake", properties=properties
        )
        people = []
        for person in citation["authors"]:
            name = person.get("name") or f"{person['given-names']} {person['family-names']}"
            kind = "Organization" if "name" in person else "Person"
            place = person.get("orcid") or f"#{name.replace(' ', '-')}"
            people.append(self.entity(place, kind, name=name))
        crate.root_dataset["author"] = workflow["creator"] = people
        for kind, name in _PROFILES.items():
            place = f"https://w3id.org/ro/wfrun/{kind}/{PROFILE_VERSION}"
            profile = self.entity(place, "CreativeWork", name=name, version=PROFILE_VERSION)
            crate.root_dataset.append_to("conformsTo", profile)
        for name in names:
            if name != WORKFLOW:
                self.file(self.out / name)

    def add_run(self, jobs: Sequence[_Computed], overrides: str, command: str) -> Any:
        """Add the action of the whole workflow, from the first job to the last; its software."""
        workflow: Any = self.crate.mainEntity
        versions = {n: v for computed in jobs for n, v in computed.job.code.versions.items()}
        workflow["softwareRequirements"] = [
            self.software(f"#package-{name}", name, version)
            for name, version in sorted(versions.items())
        ]
        ends = ("started", "ended")
        times = [computed.facts[end] for computed in jobs for end in ends if end in computed.facts]
        noted = {"name": "overrides", "value": overrides or "none"}
        run = self.entity(
            "#run",
            "CreateAction",
            name="The whole run",
            description=f"`{command}` leads to the results.",
            instrument=workflow,
            object=[self.entity("#overrides", "PropertyValue", **noted)],
            **({"startTime": min(times), "endTime": max(times)} if times else {}),
        )
        self.crate.root_dataset["mentions"] = [run]
        return run

    def add_jobs(self, jobs: Mapping[str, _Computed]) -> None:
        """Add an action per job, from the objects of its inputs to its object."""
        objects = {recipe: self._object(computed) for recipe, computed in jobs.items()}
        noted = {"startTime": "started", "endTime": "ended", "description": "machine"}
        for recipe, (job, _, facts) in jobs.items():
            action = self.entity(
                f"#{recipe}",
                "CreateAction",
                name=job.label,
                identifier=recipe,
                instrument=self.software(f"#{job.code.entry}", job.code.entry, job.code.source),
                result=objects[recipe],
                **({"object": [objects[i.recipe] for i in job.needs]} if job.needs else {}),
                **{name: facts[key] for name, key in noted.items() if key in facts},
            )
            self.crate.root_dataset.append_to("mentions", action)

    def _object(self, computed: _Computed) -> Any:
        """The folder of an object, which other jobs may have as their result, too."""
        result = computed.manifest.result
        folder = Store(self.out / ARTEFACTS).object_folder(result.object)
        place = f"{folder.relative_to(self.out).as_posix()}/"
        if (dataset := self.crate.get(place)) is not None:
            return dataset
        facts = {"name": computed.job.label, "identifier": result.object}
        added: Any = self.crate.add_dataset(dest_path=place, properties=facts)
        added["hasPart"] = [self.file(folder / name) for name in sorted(result.files)]
        return added
