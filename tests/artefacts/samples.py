"""Results as a run would leave them, without running anything."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider.artefacts.manifest import Manifest
from slider.artefacts.plan import JobSpec, Plan, build_plan
from slider.artefacts.recipe import Code
from slider.artefacts.remote import Remote
from slider.artefacts.store import Store
from slider.core import files

CODE = Code("slider.none:run", "abc", {"python": "3.11"})
GAITS = [JobSpec("gait", f"gait {number}", CODE, {"number": number}) for number in range(6)]
LIBRARY = JobSpec("library", "library", CODE, {}, {"gaits": GAITS})
TABLE = JobSpec("table1", "table", CODE, {}, {"library": [LIBRARY]})
PLAN: Plan = build_plan({"library": LIBRARY, "table1": TABLE})
JOBS = dict(PLAN.jobs)
DATA = "deep/data.txt"


def compute(
    store: Store,
    job: JobSpec,
    text: str = "",
    summary: dict[str, Any] | None = None,
    metadata: dict[str, Any] | None = None,
    **texts: str,
) -> Manifest:
    """What a run of the job would leave: its label and a text, and CSV files of some texts."""
    with store.temporary("test") as out:
        (out / DATA).parent.mkdir()
        (out / DATA).write_text(f"{job.label} {text}")
        (out / "more.bin").write_bytes(bytes(3000))
        for name, content in texts.items():
            (out / f"{name}.csv").write_text(content)
        result = store.publish(out, summary or {"n": 1.5})
    objects = {
        name: [store.read_manifest(item.stage, item.recipe).result.object for item in jobs]
        for name, jobs in job.inputs.items()
    }
    manifest = Manifest(job.stage, job.recipe, job.input_recipes, result, objects)
    store.put_index(job.key(objects), manifest)
    files.write_json(store.metadata_path(job.stage, job.recipe), metadata or {"wall_s": 2.5})
    store.write_manifest(manifest)
    return manifest


def fill(store: Store) -> Store:
    """Compute every job of the plan."""
    for job in PLAN.jobs.values():
        compute(store, job)
    return store


def data(store: Store, manifest: Manifest) -> Path:
    """The file of a result that no other has."""
    return store.object_folder(manifest.result.object) / DATA


def forge(path: Path, signed: bool = True, **entries: object) -> None:
    """Change entries of a manifest and, so that it fits them, its digest."""
    values = files.read_json(path) | entries
    metadata = {name: values.pop(name) for name in ("run_metadata",) if name in values}
    digest = values.pop("digest")
    values["digest"] = files.digest_value(values) if signed else digest
    path.write_text(files.canonical(values | metadata))


def damage(path: Path) -> None:
    """Change the content of a file, but not its size."""
    path.chmod(0o644)
    path.write_text("B" * len(path.read_text()))


@dataclass(frozen=True)
class Place:
    """One remote with its files on this machine."""

    remote: Remote
    folder: Path

    def file(self, store: Store, job: JobSpec) -> Path:
        """The file of a result that no other has."""
        path = data(store, store.read_manifest(job.stage, job.recipe))
        return self.folder / "files" / files.digest_file(path)

    def result(self, job: JobSpec) -> Path:
        return self.folder / "results" / f"{job.recipe}.json"


def contents(store: Store) -> dict[str, Any]:
    """Objects, manifests and index of a store, without what a killed process left."""
    names = ("objects/??/*/**/*", "gait/*", "library/*", "table1/*", "index/*/*")
    paths = [path for name in names for path in store.root.glob(name) if path.is_file()]
    found = {path.relative_to(store.root).as_posix(): path.read_bytes() for path in paths}
    ends = (".part", ".run.json")
    return {name: content for name, content in found.items() if not name.endswith(ends)}
